!> Types of the law, in real kind wp: those that the kernels of every instruction set and their callers share.
module asperity_types
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_contract, only: energy_limit, max_planes, n_facet_statev, separation_limit
  use asperity_kinds, only: wp
  implicit none
  private
  public :: block_type, bracket_type, chunk_type, crushed_type, damage_type, dissipation_type, facet_type, &
    forces_type, friction_type, growth_type, history_type, local_type, material_type, moduli_type, numbers_type, &
    plane_type, points_type, profile_type, response_type, separation_type, tensor_type, update_type, vector_type

  !> Points processed at a time: few enough that the data of the inner loops stay in the first-level cache.
  integer, parameter, public :: chunk = 64
  !> Largest admissible separation, as a multiple of s0: its square and its energies stay in the range of the kind.
  real(wp), parameter, public :: largest_separation = &
    real(min(separation_limit, sqrt(sqrt(real(huge(1.0_wp), real64)))), wp)
  !> Largest admissible energy in a state: the energy of one more increment can be added without overflow.
  real(wp), parameter, public :: largest_energy = real(min(energy_limit, 0.5_real64*real(huge(1.0_wp), real64)), wp)

  !> Rounding error of an energy, as a multiple of K_t |s_T|^2/2, or on a facet of the energies of |s|; the guard treats
  !> a smaller negative release as zero.
  real(wp), parameter, public :: unseen = 8.0_wp*epsilon(1.0_wp)

  !> Argument up to which profile_at uses a series of artanh: the first omitted term is below a rounding error. On
  !> facets with a foot of at most mild_slope (38 degrees) no argument is larger.
  real(wp), parameter, public :: short_artanh = 1.0_wp/16.0_wp
  real(wp), parameter, public :: mild_slope = sqrt(((1.0_wp + 3.0_wp*short_artanh)/(1.0_wp - short_artanh))**2 - 1.0_wp)

  !> Ends of the parts of a long increment for its accounts, as positions on the step: the first parts, in which a
  !> dashpot pushes or a facet is crushed, are short.
  integer, parameter, public :: most_parts = 8
  real(wp), parameter, public :: part_ends(0:most_parts) = [0.0_wp, 1.0_wp, 4.0_wp, 9.0_wp, 16.0_wp, 25.0_wp, &
    36.0_wp, 49.0_wp, 64.0_wp]/64.0_wp

  !> Numbers that the law derives from its constants, none of them negative, in real kind wp and the user's consistent
  !> units.
  type :: numbers_type
    real(wp) :: eta         !! ductility (5)
    real(wp) :: inv_eta     !! its inverse
    real(wp) :: mu          !! friction coefficient (18)
    real(wp) :: k_n         !! normal stiffness of the bond (12), stress/length
    real(wp) :: k_t         !! tangential stiffness (12), stress/length
    real(wp) :: k_c         !! normal stiffness of the contact, stress/length
    real(wp) :: kn_kt       !! k_n/k_t
    real(wp) :: kc_kt       !! k_c/k_t
    real(wp) :: inv_s01_2   !! 1/s01^2, s01 = separation at the onset of damage in mode I
    real(wp) :: inv_s02_2   !! 1/s02^2, s02 = slip at the onset of damage in mode II
    real(wp) :: s02_s01_2   !! (s02/s01)^2
    real(wp) :: s0          !! the smaller of s01 and s02, length
    real(wp) :: tau_v       !! relaxation time of the damage, 0: none
    real(wp) :: height      !! height of the asperities, 0: infinite, length
    real(wp) :: inv_height  !! its inverse, 0: the height is infinite
    real(wp) :: foot        !! climbed slip up to which the profile is straight: 0, or huge if the height is infinite
    real(wp) :: inv_w0      !! inverse of the work that wears 63 % of a facet off, 0: no wear, 1/(stress*length)
    real(wp) :: kt_crush    !! k_t over the pressure that crushes the asperities to 69 %, 0: none, 1/length
    real(wp) :: damage0     !! damage of every plane from the start
    real(wp) :: inv_largest_closure   !! of the hyperbolic contact, 0: linear contact, 1/length
    real(wp) :: linear_from           !! closure beyond which the pressure grows linearly, huge: never, length
    real(wp) :: damping     !! of the closed contact, c of PROPS 24, 0: none, stress*time/length
    real(wp) :: inv_longest_2   !! of the longest increment that is not long, 0: none is long, 1/length^2
    real(wp) :: unguarded   !! negative dissipation that is admitted, over k_t/2: huge, or 0 with the guard
  end type numbers_type

  !> Constants of the law: numbers and options.
  type, extends(numbers_type) :: material_type
    logical :: guard        !! whether damage grows only where its dissipation is >= 0
    logical :: curved       !! whether the contact of a plane lies on a curved facet
    logical :: hyperbolic   !! whether the contact closes by a hyperbola
    logical :: general      !! whether it lies on a facet, closes by a hyperbola or has a dashpot
    logical :: wears        !! whether the facets wear or are crushed
    logical :: damps        !! whether a dashpot acts on the closed contact
    logical :: exact        !! whether a loop, which sets it, takes long increments by their phases
    logical :: by_points    !! whether the loop of a kernel, which sets it, runs over points, else over planes
  end type material_type

  !> What depends on the duration of an increment. Growth of the damage: weights of the old damage and of (7) in the new
  !> damage. Dashpot: its time c/K_c over the duration.
  type :: growth_type
    real(wp) :: weight_old  !! weight of the old damage: 0 without viscosity
    real(wp) :: weight_new  !! weight of the damage of (7): 1 without viscosity
    real(wp) :: weight_eta  !! weight_new/eta
    real(wp) :: limit       !! upper limit of the part due to (7): weight_new, or 0 if the guard lets no damage grow
    real(wp) :: lag         !! c/(K_c dt): stress of the dashpot over that of the spring, for the same change; 0: none
  end type growth_type

  !> Vector in the axes (N, Tx, Ty) of the interface.
  type :: vector_type
    real(wp) :: n, x, y
  end type vector_type

  !> Vector in the axes (n, t, h) of a plane.
  type :: local_type
    real(wp) :: n, t, h
  end type local_type

  !> Axes (1) and weight of a plane; the component of h along N is zero. A facet needs the direction e in which the
  !> plane rises in the average surface, and its slope tan(theta) with the inverse.
  type :: plane_type
    type(vector_type) :: n, t, h
    real(wp) :: gamma
    real(wp) :: e_x, e_y
    real(wp) :: slope, inv_slope
  end type plane_type

  !> State of a plane: damage, inelastic slip (length), worn share of its facet and frictional work there
  !> (stress*length).
  type :: history_type
    real(wp) :: alpha, s_dit, s_dih
    real(wp) :: omega, wear_work
  end type history_type

  !> Result of the return mapping; the stress of friction is stress*m.
  type :: friction_type
    real(wp) :: trial       !! norm of the trial stress (30)
    real(wp) :: inv_trial   !! its inverse
    real(wp) :: strength    !! friction strength mu p
    real(wp) :: stress      !! norm of the stress of friction
    real(wp) :: slip        !! increment of the inelastic slip (38), length
    real(wp) :: p           !! pressure, with that of a dashpot
    real(wp) :: stiffness   !! its derivative by the closure
    real(wp) :: m_t, m_h    !! direction of the trial stress
  end type friction_type

  !> Damage at the end of an increment.
  type :: damage_type
    real(wp) :: alpha       !! damage (25)
    real(wp) :: inv_r       !! 1/r = 1/(1 + beta), beta of (6)
    real(wp) :: free        !! part due to (7), before the limit is applied
  end type damage_type

  !> Point of contact on the profile of a facet.
  type :: profile_type
    real(wp) :: decay    !! slope over that of the foot
    real(wp) :: z        !! height of the curved part if nothing is worn, length
    real(wp) :: c        !! cosine of the slope angle phi
    real(wp) :: length   !! length climbed on the curved part
  end type profile_type

  !> Kinematics of the curved facet of a plane (docs/extensions.md): the separation of the contact, its gradients and
  !> its second derivatives.
  type :: facet_type
    type(local_type) :: s       !! separation of the contact: gap g, climbed length, h component
    real(wp) :: z               !! height of the profile at the point of contact, length
    real(wp) :: c, q            !! cosine and sine of the slope angle phi at the point of contact
    real(wp) :: f               !! 1 + (w - z) d phi/d u
    real(wp) :: n_wu, n_uu      !! second derivatives of s%n, 1/length
    real(wp) :: t_wu, t_uu      !! second derivatives of s%t, 1/length
    real(wp) :: bend            !! - d phi/d u over q c, 1/length
    real(wp) :: phi_omega       !! derivative of phi by the worn share
    real(wp) :: n_omega, t_omega   !! derivatives of s%n and s%t by the worn share, length
  end type facet_type

  !> Unworn facet at a separation of which the pressure crushes a share.
  type :: crushed_type
    real(wp) :: level        !! opening of the interface, length
    real(wp) :: rise         !! height at the point of contact, length
    real(wp) :: slope        !! slope there
    real(wp) :: per_length   !! factor of the pressure times k_c/crush, 1/length
  end type crushed_type

  !> Pressure on a facet that it crushes, and its bracket, over k_c: closures if the contact were linear, length.
  type :: bracket_type
    real(wp) :: at, low, high
  end type bracket_type

  !> Separations of a plane.
  type :: separation_type
    type(local_type) :: bond     !! that of the straight plane, length
    type(local_type) :: contact  !! that of the plane or of its facet, length
    type(facet_type) :: facet    !! defined if the contact lies on a facet
  end type separation_type

  !> Response of a plane to an increment.
  type :: response_type
    type(friction_type) :: friction   !! of the contact
    type(damage_type) :: damage       !! of the bond
    type(history_type) :: new         !! state at the end
  end type response_type

  !> Factors of friction and of growing damage in the tangent of a plane; stiffnesses are divided by k_t.
  type :: moduli_type
    real(wp) :: tangential      !! tangential stiffness of the contact across the slip
    real(wp) :: slip_term       !! alpha times what it is less along the slip, with the sign changed
    real(wp) :: coupling        !! alpha times the derivative of the friction by the normal separation
    real(wp) :: damage          !! factor of d alpha/d s: 1/(eta r^3), 0 if the damage does not grow
    type(local_type) :: omega   !! d omega/d (w, u, v), 0 if the pressure crushes nothing, 1/length
  end type moduli_type

  !> What dissipates energy in a plane, at the start or at the end of an increment.
  type :: forces_type
    real(wp) :: y           !! driving force of damage, over k_t/2
    real(wp) :: strength    !! friction strength alpha mu p, over mu k_t
  end type forces_type

  !> Energies that a plane dissipates in an increment, over k_t/2.
  type :: dissipation_type
    real(wp) :: rupture, friction
  end type dissipation_type

  !> Derivative of a vector by a vector, both in the axes of the interface: xn is the derivative of x by n.
  type :: tensor_type
    real(wp) :: nn, xn, yn, nx, xx, yx, ny, xy, yy
  end type tensor_type

  !> What an increment does to a plane: its state at the end, and its terms of the sums over the planes without the
  !> weight.
  type :: update_type
    type(history_type) :: new
    real(wp) :: stored             !! energy at the end, over k_t/2
    type(dissipation_type) :: spent
    type(vector_type) :: traction  !! over k_t
    type(tensor_type) :: tangent   !! over k_t; undefined if it is not wanted
  end type update_type

  !> An interface in real kind wp.
  type :: block_type
    integer :: n_planes                       !! number of planes
    type(material_type) :: material           !! constants of the law
    type(growth_type) :: growth               !! of the damage in the increment, without the guard
    type(plane_type) :: planes(max_planes)    !! axes and weights
  end type block_type

  !> Points of a call and how their states are stored: component by component, with a leading dimension >= n.
  type :: points_type
    real(wp), dimension(chunk, 3) :: s_old, s_new    !! separation (N, Tx, Ty) at start and end, length
    integer :: n                                     !! points, at most chunk
    integer :: n_old, n_new                          !! leading dimensions of the states at start and end
  end type points_type

  !> Sums over the planes: damage, energies over 1/2, traction.
  integer, parameter, public :: i_damage = 1, i_stored = 2, i_rupture = 3, i_friction = 4, i_traction = 5, n_sums = 7

  !> Start and end of the increment, as indices of arrays.
  integer, parameter, public :: before = 1, after = 2

  !> What the loops over the points of a chunk share: the separations with their offsets, the sums over the planes, and
  !> the states of the facets of one plane. The arrays are the first components, so that their vectors are aligned.
  type :: chunk_type
    real(wp) :: s(chunk, 3, before:after)                      !! separation at start and end, length
    real(wp) :: sums(chunk, n_sums)                            !! sums over the planes, energies over 1/2
    real(wp) :: facets(chunk, n_facet_statev)                  !! state of the facets of a plane, start -> end
    real(wp) :: crushed(chunk)                                 !! share of a plane that the pressure at the end crushes
    real(wp) :: accounts(chunk, 2)                             !! sums of rupture and friction of the long ones
    integer :: long(chunk)                                     !! points with long increments, the last one repeated
    integer :: n_long                                          !! their number
    integer :: n_gathered                                      !! with repetitions, a multiple of group
    integer :: n                                               !! points, a multiple of group, at most chunk
    integer :: n_old, n_new                                    !! leading dimensions of the states at start and end
  end type chunk_type

end module asperity_types
