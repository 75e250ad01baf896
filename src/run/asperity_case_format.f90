!> Description of a case file: its groups and their entries, with the defaults of the library.
module asperity_case_format
  use asperity_case_material, only: prop_names
  implicit none
  private
  public :: format_line

  !> {group} is replaced by the constants of a group with their defaults.
  character(len=*), parameter, public :: case_format(47) = [character(len=104) :: &
    "case file: groups &name entry = value, ... /; comments after !; names in any case", &
    "  &case      title = '...', planes = .false.                                     ! optional", &
    "             tolerance   relative, 1e-8 to 0.1: increments are halved until two runs of the whole path", &
    "               agree; rows are left out where straight lines stay within it", &
    "  &material  {material}", &
    "             kn, ks instead of sigma0, Gc, eta and kc: a joint without bond", &
    "  &pattern   sides, {pattern}", &
    "             or normals = n_N, n_Tx, n_Ty, ..., weights = gamma, ...", &
    "  &umat      instead of both: library = 'file', symbol = 'umat_', props = ..., nstatv = 0,", &
    "             length, stiffness (separation at the strength, elastic stiffness), order = 'N,Tx,Ty',", &
    "             thickness = 1, state = ... (STATEV at the start), damage = 0 (STATEV for this column),", &
    "             limit = 60 (s for an increment); for checks ntens = 2, 3, 6 (numbers of components that it", &
    "             can have), energies = .true.", &
    "  &step      one or more; each starts from the end of the last one", &
    "    s_N | t_N, s_Tx | t_Tx, s_Ty | t_Ty   target separation or traction: one value or a list", &
    "               (a shorter list repeats its last value); without an entry a component keeps its last", &
    "               prescribed value, in the first step s = 0", &
    "    slip, direction = 0   s_Tx and s_Ty together, along a direction (degrees from Tx to Ty)", &
    "    k_N, k_Tx, k_Ty       stiffness of the surroundings (CNS): the traction is its target minus", &
    "               k (s - s at the start of the step), until k is set again or s is prescribed", &
    "    increments = 100      to each target, one number or a list", &
    "    follow = 'stable'     jumps where the stable path ends; 'branch': continues along the unstable", &
    "               part, where the prescribed values turn back and forward again; every step is a row", &
    "    arc = 0.05            longest step along the branch over s0, instead of increments", &
    "    cycles = 1            number of times that the lists are followed", &
    "    time = 1.0            duration of the step, or a list: to each target", &
    "  &expect    end = 'complete' | 'lost', and values of the last row (columns, or slip = |s_T|) within", &
    "             tolerance; when = value of the sweep: for that run only             ! optional", &
    "  &sweep     name = 'x', values = ...: a run for every value; x stands for a number  ! optional", &
    "  &initial   traction = t_N, t_Tx, t_Ty, damage = alpha, slip = s_dit, s_dih: state of the planes at", &
    "             the start (for all planes, or for each), and the traction that they carry at separation", &
    "             zero                                                                ! optional", &
    "  &state     separation = s_N, s_Tx, s_Ty, statev = ..., work: start of the run (else virgin, s = 0);", &
    "             a run that loses equilibrium writes OUT.failed.nml with this group  ! optional", &
    "  &replay    instead of &step: file = '...' (CSV beside the case), ntens = 3,", &
    "             {replay}, dtime = 1; columns s_N, s_Tx, s_Ty or", &
    "             e_1 ... e_<ntens>, time", &
    "example: slip of 0.6 along 30 degrees under a normal traction of -5", &
    "  &material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /", &
    "  &pattern sides = 4, theta = 30.0 /", &
    "  &step t_N = -5.0 /", &
    "  &step slip = 0.6, direction = 30.0, increments = 240 /", &
    "rows: step, increment, time, separation, traction, damage, energies, Newton iterations (of a replay:", &
    "  calls), event: onset, damaged, open, close, slip, snap, turn, substeps, cut, lost; joined by +", &
    "  onset, damaged: damage begins, is complete; open, close, slip: of a plane; snap: to another branch;", &
    "  turn: the prescribed values turn; substeps: sub-increments; cut: umat requested a smaller one;", &
    "  lost: no equilibrium beyond it"]

contains

  !> Line of the description, with the constants of a group.
  pure function format_line(i) result(line)
    integer, intent(in) :: i   !! from 1, in case_format
    character(len=:), allocatable :: line
    character(len=*), parameter :: groups(3) = [character(len=8) :: "material", "pattern", "replay"]
    integer :: at, k
    line = trim(case_format(i))
    do k = 1, size(groups)
      at = index(line, "{" // trim(groups(k)) // "}")
      if (at > 0) line = line(:at - 1) // prop_names(trim(groups(k))) // line(at + len_trim(groups(k)) + 2:)
    end do
  end function format_line

end module asperity_case_format
