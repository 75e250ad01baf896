!> Tolerances of the equilibrium solver and of initial states, each with its reason.
module asperity_tolerances
  use asperity_kinds, only: wp
  implicit none
  private

  !> Largest residual of an equilibrium, relative to the traction scale: some hundred rounding errors of the terms of
  !> the sum over the planes.
  real(wp), parameter, public :: residual_tolerance = 1.0e-13_wp
  !> Residual that a further Newton step does not reduce, relative to strength and prescribed tractions.
  real(wp), parameter, public :: rounding = 16.0_wp*epsilon(1.0_wp)
  !> Smallest traction scale, relative to the strength: an unloaded equilibrium must not fail on rounding. For an
  !> initial state it is the strength itself, so that a rounding error of the host does not count as a tension.
  real(wp), parameter, public :: finest_scale = 1.0e-6_wp, finest_initial_scale = 1.0_wp
  !> Largest traction scale, relative to strength and prescribed tractions: the residual never exceeds 1e-7 of them,
  !> however large free separations grow. For an initial state it never exceeds 5e-11, half of the accuracy documented
  !> in docs/reference/driver.md.
  real(wp), parameter, public :: coarsest_scale = 1.0e6_wp, coarsest_initial_scale = 500.0_wp

  !> Largest number of Newton iterations: quadratic convergence needs fewer than 10, and switches of planes add a few.
  integer, parameter, public :: most_iterations = 25
  !> Condition number above which the derivative of the residual counts as singular.
  real(wp), parameter, public :: worst_condition = 1.0e9_wp
  !> Longest step if the derivative is singular, relative to that of an elastic interface: there is no step in a
  !> direction without stiffness. The step of an initial state has no such limit, as open planes have to come into
  !> contact.
  real(wp), parameter, public :: longest_step = 31622.8_wp, longest_initial_step = worst_condition
  !> Negative numbers of a smaller magnitude, relative to the elastic stiffness, count as zero in the stability
  !> criterion: they are rounding errors of sums over the planes and of products of three of these sums.
  real(wp), parameter, public :: instability = 1.0e-12_wp

  !> Smallest fraction of an increment, and of an initial traction, that is tried; a fold is located to this accuracy.
  real(wp), parameter, public :: smallest_share = 2.0_wp**(-20), smallest_initial_share = 2.0_wp**(-17)
  !> Distance from a kink at which Newton's method starts on its closing side, relative to s0.
  real(wp), parameter, public :: touch = 1.0e-4_wp
  !> Smallest jump of a separation that counts as a snap, relative to s0.
  real(wp), parameter, public :: snap_resolution = 0.01_wp
  !> Tolerated difference between a step and the mean of the two tangent predictions, as a fraction of s0 (RP-32 jumps
  !> by 0.1 s0) or of the prescribed change, whichever is larger.
  real(wp), parameter, public :: unexplained = 0.01_wp, unexplained_share = 0.025_wp

  !> Tolerated energy that does not balance in a sub-increment, relative to the energy of a plane at its strength or to
  !> the terms of the balance. It is the error of the trapezoidal rule in a step of 0.3 s0 in which a bond breaks.
  real(wp), parameter, public :: unbalanced = 0.01_wp
  !> The same for a step of s0 of the motion to another branch; shorter steps are allowed less in proportion, as the
  !> energy that a snap releases is a sum over the steps.
  real(wp), parameter, public :: unbalanced_motion = 3.0e-4_wp

  !> Largest growth of the damage of a plane in a sub-increment of an initial traction; a larger one may be a jump to
  !> another branch.
  real(wp), parameter, public :: most_growth = 0.05_wp

  !> Smallest damping of a motion, relative to the elastic stiffness; the largest is its inverse.
  real(wp), parameter, public :: least_damping = 1.0e-13_wp
  !> Change of the damping after a step that converged, and after one that did not.
  real(wp), parameter, public :: less_damping = 0.5_wp, more_damping = 4.0_wp
  !> Separation at which a motion counts as endless, relative to s_f and the elastic separation of the given values.
  real(wp), parameter, public :: farthest = 1000.0_wp
  !> Largest prescribed separation that a load path may have, relative to s_f: the numbers beside it differ by 1e-4 s_f,
  !> so that no damage could be resolved beyond it.
  real(wp), parameter, public :: farthest_prescribed = 1.0e12_wp

end module asperity_tolerances
