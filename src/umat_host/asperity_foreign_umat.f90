!> The law of a UMAT in a shared library, as the solver sees it.
!>
!> A state consists of the energies per unit area in their places in STATEV of this project, what `u_work` and `u_time`
!> name, STRESS (NTENS) and the STATEV of the UMAT.
module asperity_foreign_umat
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_null_char, c_ptr
  use asperity_case_umat, only: umat_type
  use asperity_contract, only: v_damage, v_friction, v_rupture, v_stored
  use asperity_kinds, only: wp
  use asperity_point_law, only: call_type, point_law, point_type
  use asperity_text, only: integer_text
  use asperity_text_file, only: last_separator
  use asperity_umat_worker, only: c_text
  implicit none
  private
  public :: complete_umat, open_umat, umat_name

  !> Places in a state: work of the traction so far, time; the numbers before STRESS and STATEV.
  integer, parameter, public :: u_work = 5, u_time = 6
  integer, parameter, public :: n_header = 6
  !> Duration of a jump for a UMAT, which takes no time, as Abaqus has no increment without time.
  real(wp), parameter :: no_time = 1.0e-12_wp
  !> Separation at which the bond is broken, and largest separation, relative to `length`: that of a UMAT is not known.
  real(wp), parameter, public :: far = 100.0_wp
  real(wp), parameter :: farthest_length = 1.0e10_wp
  !> Longest path.
  integer, parameter :: longest_path = 4096

  !> How a check, which does not obey PNEWDT, goes along a path.
  type, public :: how_type
    logical :: strict = .false.       !! whether arguments that are the host's must not change
    logical :: ones = .false.         !! whether the numbers between the arguments are 1, or NaN
    logical :: marks = .false.        !! whether each number of DDSDDE must be written
    character(len=6) :: absent = ""   !! name of the argument that is NULL; blank: none
    logical :: tries = .false.        !! whether each increment is tried before
    logical :: rests = .false.        !! whether each increment is followed by one without a change, in no time
    logical :: late = .false.         !! whether the walk begins where the path has unloaded most
    logical :: threads = .false.      !! whether the points are in threads
    integer :: parts = 1              !! of an increment
  end type how_type

  !> A UMAT with its constants.
  type, extends(point_law), public :: foreign_law
    type(umat_type) :: umat                          !! entries of &umat; empty library: this program
    real(wp) :: origin = 0.0_wp                      !! time of the UMAT at the start of the load path
  contains
    procedure :: update
    procedure, nopass :: energies
    procedure :: magnitude
    procedure :: state_name
    procedure :: virgin
  end type foreign_law

  ! the routines of C act on the one UMAT of this process
  interface
    !> Open a library.
    subroutine c_open(library, symbol, job, checks, strict, ones, marks, absent) bind(c, name="umat_open")
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: library(*), symbol(*), job(*), absent(*)
      integer(c_int), value :: checks, strict, ones, marks
    end subroutine c_open
    !> POSIX: the whole path of a file; NULL if there is none.
    function c_whole_path(path, whole) bind(c, name="realpath") result(found)
      import :: c_char, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(out) :: whole(*)
      type(c_ptr) :: found
    end function c_whole_path
    !> Call a routine.
    subroutine c_call(attempt, ntens, nstatv, nprops, props, stran, dstran, time, dtime, counts, stress, statev, &
                      ddsdde, energies, requested) bind(c, name="umat_call")
      import :: c_double, c_int
      implicit none
      integer(c_int), value :: attempt, ntens, nstatv, nprops
      real(c_double), intent(in) :: props(*), stran(*), dstran(*), time(2)
      real(c_double), value :: dtime
      integer(c_int), intent(in) :: counts(2)
      real(c_double), intent(inout) :: stress(*), statev(*), ddsdde(*), energies(3)
      real(c_double), intent(out) :: requested
    end subroutine c_call
  end interface

contains

  !> Set the scales of a law whose other components are set, and make its path whole, as the case of a failed increment
  !> may lie elsewhere.
  subroutine complete_umat(law)
    type(foreign_law), intent(inout) :: law   !! with its UMAT -> complete
    character(kind=c_char) :: path(longest_path)
    law%n_state = n_header + law%umat%ntens + law%umat%nstatv
    law%first_own = u_work
    law%s_0 = law%umat%length
    law%stiffness = law%umat%stiffness
    law%s_f = far*law%s_0
    law%least_stiffness = law%stiffness
    law%largest_stiffness = law%stiffness
    law%stress = law%stiffness*law%s_0
    law%bound = farthest_length*law%s_0
    ! neither is known
    law%discontinuous = .true.
    law%rate_dependent = .true.
    if (c_associated(c_whole_path(law%umat%library // c_null_char, path))) law%umat%library = c_text(path)
  end subroutine complete_umat

  !> Open the UMAT in this process, which must be a child: what goes wrong ends it. No process opens more than one.
  subroutine open_umat(law, how)
    type(foreign_law), intent(in) :: law           !! the law
    type(how_type), intent(in), optional :: how    !! absent: as a host calls it
    type(how_type) :: this
    if (present(how)) this = how
    call c_open(law%umat%library // c_null_char, law%umat%symbol // c_null_char, job_name(law) // c_null_char, &
      merge(1_c_int, 0_c_int, present(how)), merge(1_c_int, 0_c_int, this%strict), merge(1_c_int, 0_c_int, this%ones), &
      merge(1_c_int, 0_c_int, this%marks), trim(this%absent) // c_null_char)
  end subroutine open_umat

  !> Name of the UMAT in messages.
  pure function umat_name(law) result(name)
    class(foreign_law), intent(in) :: law   !! the law
    character(len=:), allocatable :: name
    name = law%umat%symbol
    if (len(law%umat%library) > 0) name = name // " of " // law%umat%library
  end function umat_name

  !> Name of the job, as GETJOBNAME gives it: that of the case file.
  pure function job_name(law) result(name)
    class(foreign_law), intent(in) :: law   !! the law
    character(len=:), allocatable :: name
    integer :: dot
    name = "case"
    if (.not. allocated(law%umat%place%file)) return
    name = law%umat%place%file(last_separator(law%umat%place%file) + 1:)
    dot = index(name, ".", back=.true.)
    if (dot > 1) name = name(:dot - 1)
  end function job_name

  !> Name of a number of a state behind the energies, for a column.
  pure function state_name(law, i) result(name)
    class(foreign_law), intent(in) :: law   !! the law
    integer, intent(in) :: i                !! from u_work on
    character(len=:), allocatable :: name
    if (i <= n_header) then
      name = trim(merge("umat_work", "umat_time", i == u_work))
    else if (i <= n_header + law%umat%ntens) then
      name = "stress_" // integer_text(i - n_header)
    else
      name = "statev_" // integer_text(i - n_header - law%umat%ntens)
    end if
  end function state_name

  !> State of a virgin point.
  pure function virgin(law) result(state)
    class(foreign_law), intent(in) :: law   !! the law
    real(wp) :: state(law%n_state)
    state = 0.0_wp
    state(n_header + law%umat%ntens + 1:) = law%umat%first
    if (law%umat%damage > 0) state(v_damage) = law%umat%first(law%umat%damage)
  end function virgin

  !> Traction, state and tangent at a separation, and the fraction of the increment that the routine asks for by
  !> PNEWDT; one that fails ends the process. Where it asks for less, the results are those of an elastic joint.
  subroutine update(law, call, old, new, requested)
    class(foreign_law), intent(in) :: law       !! the law
    type(call_type), intent(in) :: call         !! place in a load path, and duration
    type(point_type), intent(in) :: old         !! separation and state at the start
    type(point_type), intent(inout) :: new      !! separation at the end -> traction, tangent and state
    real(wp), intent(out) :: requested          !! of the increment
    integer, parameter :: ledger(3) = [v_stored, v_friction, v_rupture]
    real(wp) :: before(3), ddsdde(law%umat%ntens, law%umat%ntens), energies(3), time(2)
    real(wp), dimension(law%umat%ntens) :: dstran, stran, stress
    real(wp) :: statev(law%umat%nstatv)
    integer :: i, j
    stran = 0.0_wp
    dstran = 0.0_wp
    before = 0.0_wp
    do i = 1, 3
      if (law%umat%position(i) == 0) cycle
      stran(law%umat%position(i)) = old%s(i)/law%umat%thickness
      dstran(law%umat%position(i)) = (new%s(i) - old%s(i))/law%umat%thickness
      before(i) = old%state(n_header + law%umat%position(i))
    end do
    stress = old%state(n_header + 1:n_header + law%umat%ntens)
    statev = old%state(n_header + law%umat%ntens + 1:)
    energies = old%state(ledger)/law%umat%thickness
    time = max(0.0_wp, old%state(u_time) - [law%origin + call%began, 0.0_wp])
    call c_call(int(call%attempt, c_int), int(law%umat%ntens, c_int), int(law%umat%nstatv, c_int), &
      size(law%umat%props, kind=c_int), law%umat%props, stran, dstran, time, max(call%duration, no_time), &
      int([call%step, call%increment], c_int), stress, statev, ddsdde, energies, requested)
    new%state = old%state
    new%traction = before + law%stiffness*(new%s - old%s)
    new%tangent = 0.0_wp
    do i = 1, 3
      new%tangent(i, i) = law%stiffness
    end do
    if (requested < 1.0_wp) return
    new%traction = 0.0_wp
    new%tangent = 0.0_wp
    associate (position => law%umat%position, h => law%umat%thickness)
      do j = 1, 3
        if (position(j) == 0) cycle
        new%traction(j) = stress(position(j))
        do i = 1, 3
          if (position(i) > 0) new%tangent(i, j) = ddsdde(position(i), position(j))/h
        end do
      end do
    end associate
    new%state(ledger) = law%umat%thickness*energies
    new%state(u_work) = old%state(u_work) + 0.5_wp*sum((before + new%traction)*(new%s - old%s))
    new%state(u_time) = old%state(u_time) + call%duration
    new%state(n_header + 1:n_header + law%umat%ntens) = stress
    new%state(n_header + law%umat%ntens + 1:) = statev
    if (law%umat%damage > 0) new%state(v_damage) = statev(law%umat%damage)
  end subroutine update

  !> Energies of a state: stored, and the rest of the work. UMATs need not say what they dissipate.
  pure function energies(state)
    real(wp), intent(in) :: state(:)    !! state
    real(wp) :: energies(2)
    energies = [state(v_stored), state(u_work) - state(v_stored)]
  end function energies

  !> Size of the terms whose sum is the traction, stress.
  pure function magnitude(law, s, state) result(size)
    class(foreign_law), intent(in) :: law   !! the law
    real(wp), intent(in) :: s(3)            !! separation (N, Tx, Ty), length
    real(wp), intent(in) :: state(:)        !! state
    real(wp) :: size
    size = max(law%largest_stiffness*maxval(abs(s)), maxval(abs(state(n_header + 1:n_header + law%umat%ntens))))
  end function magnitude

end module asperity_foreign_umat
