!> Owner of every index, default, range, name and unit of PROPS and STATEV, and of the status codes.
!>
!> Everything else (UMAT, C API, driver, Python, tables in the docs) reads them from here.
module asperity_contract
  use asperity_kinds, only: wp
  implicit none
  private
  public :: prop_type, statev_type, n_statev, n_implex_statev, plane_statev, facet_statev, statev_row, cap_statev

  !> Version of the library; the build reads it from this line.
  character(len=*), parameter, public :: version = "0.1.0"

  ! --- PROPS ---------------------------------------------------------------------------------------------------------
  integer, parameter, public :: p_sigma0 = 1, p_gc = 2, p_eta = 3, p_mu = 4, p_theta = 5, p_m = 6, p_flat = 7, &
    p_turn = 8, p_h = 9, p_map = 10, p_sigma02 = 11, p_gc2 = 12, p_tau_v = 13, p_dalpha = 14, p_r = 15, &
    p_kc = 16, p_guard = 17, p_height = 18, p_w0 = 19, p_damage0 = 20, p_closure = 21, p_crush = 22, p_water = 23, &
    p_c = 24, p_implex = 25, p_fc = 26, p_gfc = 27, p_css = 28, p_kp = 29, p_fcr = 30
  !> PROPS before the listed planes, and how many of them have no default. The last ones are reserved: a new constant
  !> takes one of them, so that the listed planes of existing decks keep their place.
  integer, parameter, public :: n_fixed_props = 32, n_required_props = 4
  !> Number of values of a listed plane (n_N, n_Tx, n_Ty, gamma).
  integer, parameter, public :: n_listed_values = 4
  !> Largest number of inclined planes, and of all planes with the flat one.
  integer, parameter, public :: max_inclined = 64, max_planes = max_inclined + 1
  !> Smallest number of inclined planes of a regular pattern that is not flat.
  integer, parameter, public :: min_inclined = 2
  !> Tolerance of the sum of listed weights.
  real(wp), parameter, public :: weight_tolerance = 1.0e-6_wp

  !> One entry of PROPS. `lower` and `upper` are the smallest and largest admissible value; a negative `lower` is
  !> -`upper`. `plausible` are the ends of what joints have, in multiples of the sizes of the unit: the largest stress
  !> and length of a test, or sigma0, s_f and Gc. Fits, sliders and random tests stay between them.
  type :: prop_type
    character(len=8) :: name          !! symbol
    character(len=8) :: owner         !! what it belongs to: law, pattern, host or numerics; or reserved
    character(len=64) :: meaning      !! one line
    character(len=18) :: unit         !! in the user's consistent set
    character(len=40) :: admissible   !! what an error message says was expected
    real(wp) :: lower                 !! smallest admissible value
    real(wp) :: upper                 !! largest admissible value
    real(wp) :: default               !! value where the host passes fewer PROPS
    real(wp) :: plausible(2)          !! smallest and largest usual value
    character(len=6) :: scale         !! of the values: linear, log, logit (0 to 1), or whole (numbers)
    logical :: divides = .false.      !! whether 0 stands for none or a default, and the law divides by other values
    character(len=3) :: measure = ""  !! s_f: the ratio of a value above 0 to s_f is limited (length_ratio_limit)
    logical :: on_branch = .true.     !! whether a branch can be followed with a value above 0
    logical :: inclined = .false.     !! whether it is one of inclined planes only
    character(len=54) :: shown_by = ""   !! what in a test determines it
  end type prop_type

  !> Bounds of the constants. With them every product of the law is in the range of a double; they lie far outside any
  !> system of units.
  real(wp), parameter :: small = 1.0e-50_wp, large = 1.0e50_wp, top = 1.0e10_wp
  !> Largest admissible separation, as a multiple of s0: its square and the energies stay finite.
  real(wp), parameter, public :: separation_limit = 1.0e50_wp
  !> Smallest value above 0 of constants for which 0 stands for a default and by which the law divides otherwise.
  real(wp), parameter, public :: smallest_divisor = small
  !> Largest ratio of the stiffnesses of the two modes, and of its reciprocal.
  real(wp), parameter, public :: stiffness_ratio_limit = 1.0e100_wp
  !> Largest ratio of height or closure and s_f = 2 Gc/sigma0, and of its reciprocal: the curvature of a facet and the
  !> pressure stay in the range of a double.
  real(wp), parameter, public :: length_ratio_limit = 1.0e10_wp
  !> Largest energy in a state; divided by the smallest thickness it is still finite.
  real(wp), parameter, public :: energy_limit = 1.0e250_wp
  real(wp), parameter :: below_one = nearest(1.0_wp, -1.0_wp), below_right = nearest(90.0_wp, -1.0_wp)
  real(wp), parameter :: unbounded = huge(1.0_wp)

  !> What an entry says that no constant uses yet.
  character(len=*), parameter :: no_use = "no constant yet", zero_only = "0 (reserved)"

  type(prop_type), parameter, public :: prop_table(n_fixed_props) = [ &
    prop_type("sigma0", "law", "strength of one plane", "stress", "> 0 (1e-50 to 1e50)", small, large, 0.0_wp, &
              [1.0e-3_wp, 30.0_wp], "log", shown_by="rows at the peak"), &
    prop_type("Gc", "law", "rupture energy", "stress*length", "> 0 (1e-50 to 1e50)", small, large, 0.0_wp, &
              [1.0e-6_wp, 150.0_wp], "log", shown_by="rows beyond the peak, up to the residual strength,"), &
    prop_type("eta", "law", "ductility 1 - s0/sf", "-", "0 < eta < 1", small, below_one, 0.0_wp, &
              [0.05_wp, 0.995_wp], "logit", shown_by="rows before the peak"), &
    prop_type("mu", "law", "friction coefficient", "-", ">= 0 (at most 1e10)", 0.0_wp, top, 0.0_wp, &
              [0.01_wp, 2.0_wp], "log", shown_by="rows after the peak"), &
    prop_type("theta", "pattern", "inclination of the planes", "degree", "0 <= theta < 90", &
              0.0_wp, below_right, 0.0_wp, [0.5_wp, 75.0_wp], "linear", inclined=.true., shown_by="the dilation"), &
    prop_type("m", "pattern", "inclined planes (0: flat; -k: k listed planes from 33 on)", "-", &
              "0, 2..64 or -1..-64, integral", -64.0_wp, 64.0_wp, 0.0_wp, [2.0_wp, 32.0_wp], "whole"), &
    prop_type("flat", "pattern", "weight of the flat plane", "-", "0 <= flat <= 1", 0.0_wp, 1.0_wp, 1.0_wp/3.0_wp, &
              [0.005_wp, 0.95_wp], "logit", inclined=.true., shown_by="tests at several pressures with the dilation"), &
    prop_type("turn", "pattern", "rotation of the pattern about N", "degree", "any finite angle", &
              -unbounded, unbounded, 0.0_wp, [-180.0_wp, 180.0_wp], "linear"), &
    prop_type("h", "host", "thickness by which the host divides (strain = separation/h)", "length", &
              "> 0 (1e-50 to 1e50), 0 means 1", 0.0_wp, large, 1.0_wp, [1.0e-6_wp, 1.0e3_wp], "log", divides=.true.), &
    prop_type("map", "host", "order of the host's components", "-", "0 or 1", 0.0_wp, 1.0_wp, 0.0_wp, &
              [0.0_wp, 1.0_wp], "whole"), &
    prop_type("sigma02", "law", "strength in mode II; 0: as sigma0", "stress", ">= 0 (0, or 1e-50 to 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0e-3_wp, 30.0_wp], "log", divides=.true., shown_by="a tension test"), &
    prop_type("Gc2", "law", "rupture energy in mode II; 0: as Gc", "stress*length", ">= 0 (0, or 1e-50 to 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0e-6_wp, 150.0_wp], "log", divides=.true., shown_by="a tension test"), &
    prop_type("tau_v", "law", "relaxation time of the viscous damage; 0: none", "time", ">= 0 (at most 1e50)", &
              0.0_wp, large, 0.0_wp, [0.01_wp, 100.0_wp], "log", on_branch=.false.), &
    prop_type("dalpha", "numerics", "largest growth of damage in an increment; 0: no limit", "-", "0 <= dalpha < 1", &
              0.0_wp, below_one, 0.0_wp, [0.01_wp, 0.5_wp], "logit"), &
    prop_type("r", "host", "NTENS = 6: in-plane stiffness as a fraction of K h", "-", "0 <= r <= 1", &
              0.0_wp, 1.0_wp, 0.0_wp, [1.0e-9_wp, 1.0_wp], "log"), &
    prop_type("kc", "law", "normal stiffness of a closed plane over Kn; 0 means 1", "-", ">= 0 (at most 1e10)", &
              0.0_wp, top, 1.0_wp, [0.1_wp, 1.0e3_wp], "log", shown_by="the closure under pressure"), &
    prop_type("guard", "law", "1: damage grows only where its dissipation is not negative", "-", "0 or 1", &
              0.0_wp, 1.0_wp, 0.0_wp, [0.0_wp, 1.0_wp], "whole", on_branch=.false.), &
    prop_type("height", "law", "asperity height, where the dilation ends; 0: it never ends", "length", &
              ">= 0 (0, or 1e-50 to 1e50)", 0.0_wp, large, 0.0_wp, [1.0e-3_wp, 1.0e3_wp], "log", .true., "s_f", &
              inclined=.true., shown_by="a slip until the dilation ends"), &
    prop_type("W0", "law", "frictional work that wears an asperity to 37 % (0: no wear)", "stress*length", &
              ">= 0 (0, or 1e-50 to 1e50)", 0.0_wp, large, 0.0_wp, [1.0e-3_wp, 1.0e3_wp], "log", .true., &
              on_branch=.false., inclined=.true., shown_by="cycles"), &
    prop_type("damage0", "law", "damage of every plane from the start; 1: a joint without bond", "-", "0 to 1", &
              0.0_wp, 1.0_wp, 0.0_wp, [0.01_wp, 0.99_wp], "logit", shown_by="rows before the peak"), &
    prop_type("closure", "law", "largest closure of the hyperbolic contact; 0: linear contact", "length", &
              ">= 0 (0, or 1e-50 to 1e50)", 0.0_wp, large, 0.0_wp, [1.0e-5_wp, 1.0e2_wp], "log", .true., "s_f", &
              shown_by="the closure under pressure"), &
    prop_type("crush", "law", "pressure that crushes asperities to 69 %; use kc >= 10 (0: none)", "stress", &
              ">= 0 (0, or 1e-50 to 1e50)", 0.0_wp, large, 0.0_wp, [1.0e-2_wp, 1.0e2_wp], "log", .true., &
              inclined=.true., shown_by="tests at several pressures"), &
    prop_type("water", "host", "number of the field that is the water pressure (0: none)", "-", &
              "0 or a whole number up to 1000", 0.0_wp, 1.0e3_wp, 0.0_wp, [0.0_wp, 1.0_wp], "whole"), &
    prop_type("c", "law", "dashpot on the closed contact; 0: none", "stress*time/length", ">= 0 (at most 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0e-3_wp, 1.0e3_wp], "log", on_branch=.false.), &
    prop_type("implex", "host", "UMAT: error of damage that IMPL-EX allows; 0: implicit", "-", "0 <= implex < 1", &
              0.0_wp, below_one, 0.0_wp, [0.02_wp, 0.2_wp], "logit"), &
    prop_type("fc", "law", "compressive strength of the joint; 0: none", "stress", ">= 0 (0, or 1e-50 to 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0_wp, 100.0_wp], "log", .true.), &
    prop_type("Gfc", "law", "energy of its softening, > 0 with fc", "stress*length", ">= 0 (0, or 1e-50 to 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0e-2_wp, 1.0e3_wp], "log", .true.), &
    prop_type("Css", "law", "weight of the shear in it: p^2 + Css tau^2 <= fc^2", "-", ">= 0 (at most 1e10)", &
              0.0_wp, top, 9.0_wp, [0.1_wp, 100.0_wp], "log"), &
    prop_type("kp", "law", "plastic closure at its peak; 0: none before it", "length", ">= 0 (0, or 1e-50 to 1e50)", &
              0.0_wp, large, 0.0_wp, [1.0e-3_wp, 1.0e2_wp], "log", .true.), &
    prop_type("fcr", "law", "residual share of it", "-", "0 <= fcr < 1", 0.0_wp, below_one, 0.1_wp, &
              [0.01_wp, 0.9_wp], "logit"), &
    prop_type("slot31", "reserved", no_use, "-", zero_only, 0.0_wp, 0.0_wp, 0.0_wp, [0.0_wp, 0.0_wp], "linear"), &
    prop_type("slot32", "reserved", no_use, "-", zero_only, 0.0_wp, 0.0_wp, 0.0_wp, [0.0_wp, 0.0_wp], "linear")]

  ! --- STATEV --------------------------------------------------------------------------------------------------------
  integer, parameter, public :: v_damage = 1, v_stored = 2, v_rupture = 3, v_friction = 4, v_status = 5, &
    v_offset = 6
  !> Numbers of state variables before those of the planes, and of a plane (alpha, s_dit, s_dih).
  integer, parameter, public :: n_point_statev = 8, n_plane_statev = 3
  !> With wear (W0 or crush > 0), state variables per facet (worn share, frictional work), after those of all planes.
  integer, parameter, public :: n_facet_statev = 2
  !> With a compressive strength (fc > 0), state variables after all others (plastic closure, its energy).
  integer, parameter, public :: n_cap_statev = 2
  !> Largest number of state variables of a point; a constant, since gfortran puts arrays of another size on the heap.
  integer, parameter, public :: most_statev = n_point_statev + (n_plane_statev + n_facet_statev)*max_planes + &
    n_cap_statev
  !> With IMPL-EX (PROPS 25), places of its state variables after all others: change of the separation in the last
  !> increment, duration of it, longest duration of the step, growth of the damage of the first plane. The errors of
  !> damage and traction follow the growth of the last plane.
  integer, parameter, public :: i_jump = 1, i_duration = 4, i_longest = 5, i_growth = 6
  integer, parameter :: n_errors = 2
  !> Rows of statev_table that must not be negative: damage, worn share, frictional work, plastic closure and its
  !> energy. The first two are at most 1.
  integer, parameter, public :: damage_row = n_point_statev + 1, worn_row = damage_row + n_plane_statev, &
    wear_work_row = worn_row + 1, kappa_row = worn_row + n_facet_statev, crushing_row = kappa_row + 1

  !> One state variable: name, meaning, unit.
  type :: statev_type
    character(len=10) :: name      !! symbol
    character(len=64) :: meaning   !! one line
    character(len=18) :: unit      !! in the user's consistent set
  end type statev_type

  type(statev_type), parameter, public :: statev_table(crushing_row) = [ &
    statev_type("damage", "sum of gamma*alpha over the planes", "-"), &
    statev_type("stored", "stored energy per unit nominal area", "stress*length"), &
    statev_type("rupture", "energy spent on rupture per unit nominal area", "stress*length"), &
    statev_type("friction", "energy dissipated by friction per unit nominal area", "stress*length"), &
    statev_type("status", "0: never called, 1: called", "-"), &
    statev_type("offset_N", "separation N that the host does not pass", "length"), &
    statev_type("offset_Tx", "separation Tx that the host does not pass", "length"), &
    statev_type("offset_Ty", "separation Ty that the host does not pass", "length"), &
    statev_type("alpha", "damage of the plane", "-"), &
    statev_type("s_dit", "inelastic slip of the plane along t", "length"), &
    statev_type("s_dih", "inelastic slip of the plane along h", "length"), &
    statev_type("worn", "worn share of the facet of the plane (if W0 or crush > 0)", "-"), &
    statev_type("wear_work", "frictional work of the facet per area (if W0 or crush > 0)", "stress*length"), &
    statev_type("kappa", "plastic closure of the joint (if fc > 0)", "length"), &
    statev_type("crushing", "energy dissipated by it per unit nominal area (if fc > 0)", "stress*length")]

  !> State variables of IMPL-EX.
  type(statev_type), parameter, public :: implex_table(i_growth + n_errors) = [ &
    statev_type("jump_N", "change of the separation N in the last increment", "length"), &
    statev_type("jump_Tx", "change of the separation Tx in the last increment", "length"), &
    statev_type("jump_Ty", "change of the separation Ty in the last increment", "length"), &
    statev_type("duration", "duration of the last increment", "time"), &
    statev_type("longest", "longest duration in this step", "time"), &
    statev_type("growth", "growth of the damage of the plane in the last increment", "-"), &
    statev_type("e_a", "largest error of a damage in the last increment", "-"), &
    statev_type("e_t", "error of the traction over the larger of sigma0 and mu p", "-")]

  ! --- component maps ------------------------------------------------------------------------------------------------
  !> Numbers of stress components that a host may have, and the largest.
  integer, parameter, public :: host_ntens(3) = [2, 3, 6], max_ntens = maxval(host_ntens)

  ! --- status codes --------------------------------------------------------------------------------------------------
  integer, parameter, public :: status_ok = 0, status_props = 1, status_nprops = 2, status_nstatv = 3, &
    status_ntens = 4, status_separation = 5, status_state = 6, status_size = 7, status_time = 8, &
    status_initial = 9, status_water = 10

contains

  !> Number of state variables of a pattern of n planes.
  pure function n_statev(n, wears, yields) result(n_total)
    integer, intent(in) :: n                  !! number of planes
    logical, intent(in), optional :: wears    !! whether W0 or crush > 0; absent: both are 0
    logical, intent(in), optional :: yields   !! whether fc > 0; absent: it is 0
    integer :: n_total
    n_total = n_point_statev + n_plane_statev*n
    if (.not. present(wears)) return
    if (wears) n_total = n_total + n_facet_statev*n
    if (.not. present(yields)) return
    if (yields) n_total = n_total + n_cap_statev
  end function n_statev

  !> Index in STATEV of the plastic closure of a joint with fc > 0, without IMPL-EX; its energy follows.
  pure function cap_statev(n, wears) result(i)
    integer, intent(in) :: n        !! number of planes
    logical, intent(in) :: wears    !! whether W0 or crush > 0
    integer :: i
    i = n_statev(n, wears) + 1
  end function cap_statev

  !> Number of state variables of IMPL-EX, which follow those of the law, for a pattern of n planes.
  pure function n_implex_statev(n) result(n_total)
    integer, intent(in) :: n   !! number of planes
    integer :: n_total
    n_total = i_longest + n + n_errors
  end function n_implex_statev

  !> Index in STATEV of alpha of plane k; s_dit and s_dih follow.
  pure function plane_statev(k) result(i)
    integer, intent(in) :: k   !! plane, from 1, flat plane first
    integer :: i
    i = n_point_statev + n_plane_statev*(k - 1) + 1
  end function plane_statev

  !> Index in STATEV of the worn share of the facet of plane k; its frictional work follows.
  pure function facet_statev(n, k) result(i)
    integer, intent(in) :: n   !! number of planes
    integer, intent(in) :: k   !! plane, from 1, flat plane first
    integer :: i
    i = n_statev(n) + n_facet_statev*(k - 1) + 1
  end function facet_statev

  !> Row of statev_table that describes a state variable.
  pure function statev_row(i, n, wears) result(row)
    integer, intent(in) :: i                  !! index in STATEV
    integer, intent(in) :: n                  !! number of planes
    logical, intent(in), optional :: wears    !! whether W0 or crush > 0; absent: they are if there are so many
    integer :: row
    row = i
    if (i > n_point_statev) row = damage_row + modulo(i - damage_row, n_plane_statev)
    if (i > n_statev(n)) row = worn_row + modulo(i - n_statev(n) - 1, n_facet_statev)
    if (.not. present(wears)) return
    if (i > n_statev(n, wears)) row = kappa_row + i - cap_statev(n, wears)
  end function statev_row

end module asperity_contract
