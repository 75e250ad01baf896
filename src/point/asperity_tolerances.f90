!> Numerical parameters of the solver, each with its reason.
module asperity_tolerances
  use asperity_kinds, only: wp
  implicit none
  private

  ! --- residual ------------------------------------------------------------------------------------------------------
  !> Largest residual of an equilibrium, relative to the traction scale: some hundred rounding errors of the terms of
  !> the sum over the planes.
  real(wp), parameter, public :: residual_tolerance = 1.0e-13_wp
  !> Smallest traction scale, relative to the strength: an unloaded equilibrium must not fail on rounding.
  real(wp), parameter, public :: finest_scale = 1.0e-6_wp
  !> Largest traction scale, relative to strength and prescribed tractions: the residual never exceeds 5e-11 of them,
  !> half of the accuracy of an initial state in docs/solver.md, or 16 rounding errors of the stiffness times the
  !> separation at the start or a prescribed one, however large free separations grow.
  real(wp), parameter, public :: coarsest_scale = 500.0_wp, &
    rounding_scale = 16.0_wp*epsilon(1.0_wp)/residual_tolerance

  ! --- Newton's method -----------------------------------------------------------------------------------------------
  !> Largest number of iterations: quadratic convergence needs fewer than 10, and switches of planes add a few.
  integer, parameter, public :: most_iterations = 25
  !> Decrease of the residual that a step must bring, as a fraction of the step (Armijo), and shortest step.
  real(wp), parameter, public :: decrease = 1.0e-4_wp, shortest_step = 2.0_wp**(-8)
  !> Condition number above which the derivative of the residual counts as singular; longest step relative to that of an
  !> elastic interface, as open planes may have to come into contact.
  real(wp), parameter, public :: worst_condition = 1.0e9_wp
  !> Negative numbers of a smaller magnitude, relative to the elastic stiffness, count as zero in the stability
  !> criterion: they are rounding errors of sums over the planes and of products of three of these sums.
  real(wp), parameter, public :: instability = 1.0e-12_wp

  ! --- following a curve of equilibria -------------------------------------------------------------------------------
  !> Smallest fraction of an increment that is tried; a fold is located to this accuracy.
  real(wp), parameter, public :: smallest_fraction = 2.0_wp**(-20)
  !> Smallest fraction of an increment that a curve must cover so that, with time, another one starts at its fold: the
  !> velocity may grow without bound towards a fold that no duration removes.
  real(wp), parameter, public :: shortest_resumed = 2.0_wp**(-16)
  !> Most curves that start so in a row, each of some 500 updates, before the point moves in no time.
  integer, parameter, public :: most_resumed = 8
  !> Longest change of a free separation in a step at whose ends the tangents differ, relative to s0: a jump that is
  !> longer cannot be hidden in such a step. RP-32 jumps by 0.1 s0.
  real(wp), parameter, public :: longest_change = 0.1_wp
  !> Change of the free separations that needs no agreement with the tangents, and tolerated difference between a
  !> longer change and the mean of the predictions by both tangents, relative to s0. The difference may also be this
  !> fraction of the change of the prescribed values.
  real(wp), parameter, public :: unexplained = 0.01_wp, unexplained_fraction = 0.025_wp
  !> A wearing joint falls if it moves by this multiple of the change of the prescribed values, and spends this multiple
  !> of their work. Its energies may not balance by this part of their terms or of the energy of a plane at its
  !> strength, or more in a smaller part of the increment than the last number.
  real(wp), parameter, public :: unprompted = 5.0_wp, unbalanced_wear = 0.003_wp, shortest_wear = 2.0_wp**(-12)
  !> Traction beyond zero that the tangent may predict where a joint opens, relative to the traction before the step.
  real(wp), parameter, public :: overshoot = 0.25_wp
  !> Distance from a kink at which Newton's method starts on its closing side, relative to s0.
  real(wp), parameter, public :: closer = 1.0e-4_wp
  !> Largest number of updates of the law in an increment: a second of work.
  integer, parameter, public :: most_updates = 50000

  ! --- snap ----------------------------------------------------------------------------------------------------------
  !> Smallest jump of a free separation that counts as a snap, relative to s0.
  real(wp), parameter, public :: snap_resolution = 0.01_wp
  !> Energy of a plane that breaks, relative to K s0^2: a smaller one is a rounding error of a joint that was broken
  !> before.
  real(wp), parameter, public :: least_rupture = 1.0e-9_wp
  !> Stiffness at which a motion comes to rest where nothing holds it, relative to the one at which the next motion
  !> starts: otherwise a slope that decays would be left in steps that are too short.
  real(wp), parameter, public :: rest = 1.0e-3_wp
  !> First step of the motion, relative to s0; two equilibria that are nearer may be taken for one.
  real(wp), parameter, public :: first_motion = 0.005_wp
  !> Displacement at the start of a motion of several free separations, relative to s0: a symmetric equilibrium that is
  !> unstable has no motion of its own.
  real(wp), parameter, public :: imperfection = 1.0e-6_wp
  !> The next motion of an increment starts this much farther away, up to the last number, if the one before has come to
  !> rest within this multiple of its own displacement: the residual of a weak instability is a rounding error there.
  real(wp), parameter, public :: more_imperfection = 10.0_wp, largest_imperfection = 1.0e-3_wp
  !> Shortest step that is judged by its energies, relative to s0.
  real(wp), parameter, public :: shortest_motion = first_motion*2.0_wp**(-10)
  !> Tolerated energy that does not balance in a step of s0 of the motion, relative to the energy of a plane at its
  !> strength or to the terms of the balance; shorter steps are allowed less in proportion, as the energy that a snap
  !> releases is a sum over the steps.
  real(wp), parameter, public :: unbalanced = 3.0e-4_wp
  !> Growth of the longest step of the motion: slow where the joint may soften, else fast.
  real(wp), parameter, public :: slow_growth = 1.02_wp, fast_growth = 2.0_wp
  !> Smallest damping of the motion, relative to the elastic stiffness.
  real(wp), parameter, public :: least_damping = 1.0e-13_wp
  !> Change of the damping after a step that converged, and after one that did not.
  real(wp), parameter, public :: less_damping = 0.5_wp, more_damping = 4.0_wp
  !> Number of steps tried over which a motion that does not move by `shortest_motion` has stopped: the damping falls
  !> from the elastic stiffness to its least value, or rises to its inverse, in fewer.
  integer, parameter, public :: most_tries = 100
  !> Separation at which a motion counts as endless, relative to s_f and to the elastic separation of the prescribed
  !> values.
  real(wp), parameter, public :: farthest = 1000.0_wp

  ! --- whole branch ---------------------------------------------------------------------------------------------------
  !> Length of a branch that counts as endless, relative to s_f, in addition to the change of the prescribed separations
  !> and to that of the springs without the interface.
  real(wp), parameter, public :: endless = 20.0_wp
  !> Longest step relative to s0: default, smallest and largest admissible value.
  real(wp), parameter, public :: default_arc = 0.05_wp, least_arc = 1.0e-5_wp, largest_arc = 1.0_wp
  !> Largest number of steps, each of which is a row: some 50 MB in a file.
  real(wp), parameter, public :: most_branch_steps = 5.0e4_wp
  !> Shortest step that is tried, relative to the longest.
  real(wp), parameter, public :: shortest_branch_step = 2.0_wp**(-16)
  !> Largest difference between the direction of a step and the mean of the directions at its ends; steps that are
  !> shorter than this, relative to s0, may pass a kink, where they differ by any amount.
  real(wp), parameter, public :: largest_turn = 0.15_wp, straight_step = 1.0e-6_wp
  !> Distance from a point at which the direction of the branch is computed, relative to s0.
  real(wp), parameter, public :: tangent_distance = 1.0e-6_wp
  !> Longest move of the point, relative to s0, while the branch is the stable path, and number of halvings of a step
  !> that is to obtain it: they leave 1e-9 of the way.
  real(wp), parameter, public :: longest_push = 2.0_wp
  integer, parameter, public :: most_halvings = 30
  !> Number of halvings that locate a fold, to 1e-6 of the step.
  integer, parameter, public :: fold_halvings = 20
  !> Lengths of the steps that are tried at a kink, relative to s0, and cosine of the angle to the last step of a step
  !> that leads back.
  real(wp), parameter, public :: search_steps(3) = [1.0e-7_wp, 1.0e-5_wp, 1.0e-3_wp], backwards = -0.95_wp

  ! --- load paths ----------------------------------------------------------------------------------------------------
  !> Largest prescribed traction, so that the difference of two is finite.
  real(wp), parameter, public :: largest_target = 0.25_wp*huge(1.0_wp)
  !> Largest prescribed separation of a load path, relative to s_f: the numbers beside it differ by 1e-4 s_f, so that no
  !> damage could be resolved beyond it.
  real(wp), parameter, public :: farthest_prescribed = 1.0e12_wp
  !> Largest rounding error of the stiffness times a prescribed separation, relative to the prescribed tractions plus
  !> the strength: where it is larger, the traction is lost in it.
  real(wp), parameter, public :: resolved = 1.0e-6_wp
  !> Number of equal increments of an initial traction: the slips of inclined planes depend on the path.
  integer, parameter, public :: initial_increments = 32
  !> Largest number of times that damage which the guard prevented on the load path may grow at its end.
  integer, parameter, public :: most_repeats = 100
  !> Smallest and largest fraction of an attempt that a law obtains at once, and smallest one of an increment at all.
  real(wp), parameter, public :: least_cut = 0.01_wp, most_cut = 0.9_wp, smallest_part = 1.0e-6_wp

  ! --- load paths to a tolerance -------------------------------------------------------------------------------------
  !> Admissible tolerances.
  real(wp), parameter, public :: least_tolerance = 1.0e-8_wp, largest_tolerance = 0.1_wp
  !> Smallest number of increments to a target in the first run: fewer may agree by chance. Largest one of a path whose
  !> increments are halved.
  integer, parameter, public :: least_increments = 8, most_increments = 100000
  !> Largest number of values in the rows of a run, 300 MB, and those of a row besides its state variables.
  real(wp), parameter, public :: most_values = 4.0e7_wp, values_of_row = 60.0_wp
  !> Parts of the tolerance for the distance between two runs and for the rows that are left out; the rest is for what
  !> both runs have in common.
  real(wp), parameter, public :: measured_part = 0.4_wp, compressed_part = 0.4_wp
  !> A joint without bond has neither s_f nor strength: this part of them only keeps the scales above zero.
  real(wp), parameter, public :: unbonded = 1.0e-9_wp

end module asperity_tolerances
