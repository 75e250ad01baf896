!> Checks of a UMAT along the load path of a case, each in a process of its own with the library loaded again: a table
!> of what passed and what failed.
module check_umat
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_loc, c_null_char, c_ptr
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_control_point, only: new_point
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_loss, next_row, row_type, run_type, start_run
  use asperity_steps, only: component_names
  use asperity_text, only: integer_text, short
  use case_file, only: case_type, law_of
  use driver_messages, only: exit_input, exit_ok, say
  use foreign_umat, only: absent_argument, all_absent, c_text, foreign_law, fresh_umat, guard_nan, guard_one, n_header, &
    none_absent, open_umat, set_umat, u_work
  implicit none
  private
  public :: check_case

  !> Checks in their order, the load path before them; from `first_judged` on they are of no meaning if a routine has hidden state.
  character(len=*), parameter :: checks(0:11) = [character(len=12) :: "path", "arguments", "repeated", "cut", "alternating", &
    "threads", "absent", "components", "tangent", "symmetry", "energies", "dissipation"]
  integer, parameter :: first_hidden = 2, first_judged = 6, absent = 6
  !> Step of a difference, relative to `length`; largest error of DDSDDE and, at a kink, of a one-sided difference,
  !> relative to the stiffness; parts of an increment for the energies, and largest error of their sum, relative to the
  !> largest work; decrease of the dissipation that is a rounding error, relative to the same.
  real(wp), parameter :: difference = 1.0e-5_wp, tangent_error = 1.0e-5_wp, kink = 1.0e-3_wp, energy_error = 0.01_wp, &
    rounding = 1.0e-9_wp
  integer, parameter :: energy_parts = 16
  !> Relative error of a result with another number of components.
  real(wp), parameter :: component_error = 1.0e-12_wp

  !> The path that the checks go along, and a second one for another point.
  type :: path_type
    type(foreign_law) :: law
    real(wp), allocatable :: s(:, :)                      !! (3, n + 1) separation
    real(wp), allocatable :: dt(:)                        !! (n) durations
    integer, allocatable :: step(:), increment(:)         !! (n)
    real(wp), allocatable :: start(:)                     !! state at the start
    type(foreign_law) :: own(2)                           !! of two threads
    logical :: same(2) = .true.                           !! whether their results are those of one thread
    type(c_ptr) :: first, second                          !! results of one thread
  end type path_type

  !> Results along a path.
  type :: walk_type
    real(wp), allocatable :: t(:, :), d(:, :, :)          !! (3, n) traction, (3, 3, n) tangent
    real(wp), allocatable :: state(:, :)                  !! (:, 0:n)
    character(len=:), allocatable :: reason               !! why the routine failed; empty: it did not
  end type walk_type

  !> Second point: share of each component of the path.
  real(wp), parameter :: other(3) = [0.6_wp, -0.6_wp, 0.3_wp], same(3) = 1.0_wp

  interface
    !> Work in a process of its own.
    function c_apart(work, which, data, text, length) bind(c, name="umat_apart") result(signal)
      import :: c_char, c_funptr, c_int, c_ptr
      implicit none
      type(c_funptr), value :: work
      integer(c_int), value :: which, length
      type(c_ptr), value :: data
      ! allow(C071): the interface is that of C
      character(kind=c_char), intent(inout) :: text(*)
      integer(c_int) :: signal
    end function c_apart
    !> Two pieces of work at once.
    subroutine c_threads(work, data) bind(c, name="umat_threads")
      import :: c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: work
      type(c_ptr), value :: data
    end subroutine c_threads
  end interface

contains

  !> Check the UMAT of a case, or that of this project for its material, and print the table.
  subroutine check_case(case, label, code)
    type(case_type), intent(in) :: case      !! the case
    character(len=*), intent(in) :: label    !! name of the run in messages
    integer, intent(out) :: code             !! exit code: 0 all passed, 1 one failed
    integer, parameter :: length = 600
    type(path_type), target :: path
    character(kind=c_char) :: buffer(length)
    character(len=:), allocatable :: name, text
    logical :: hidden
    integer :: i, j, k

    code = exit_input
    call find_path(case, path, text)
    if (len(text) > 0 .and. .not. allocated(path%dt)) then
      call say(label // ": " // text)
      return
    end if
    code = exit_ok
    hidden = .false.
    name = path%law%symbol
    if (len(path%law%library) > 0) name = name // " of " // path%law%library
    write (output_unit, "(a)") label // ": " // name
    do i = 0, ubound(checks, 1)
      if (i > 0 .and. size(path%dt) == 0) exit
      if (i == 0) then
        if (len(text) == 0) text = "+" // integer_text(size(path%dt)) // " increments"
      else if (hidden .and. i >= first_judged) then
        text = "?not judged, as results depend on earlier calls"
      else
        buffer = c_null_char
        k = c_apart(c_funloc(judge), int(i, c_int), c_loc(path), buffer, length)
        text = c_text(buffer)
        if (k /= 0) text = "-the routine ended by signal " // integer_text(k)
        if (k /= 0 .and. i == absent) then
          j = 0
          do while (len(absent_argument(j)) > 0)
            if (c_apart(c_funloc(judge), int(size(checks) + j, c_int), c_loc(path), buffer, length) /= 0) &
              text = text // trim(merge(": it uses", ",        ", index(text, ":") == 0)) // " " // absent_argument(j)
            j = j + 1
          end do
        end if
      end if
      if (text(1:1) == "-") code = exit_input
      if (i >= first_hidden .and. i < first_judged) hidden = hidden .or. text(1:1) == "-"
      select case (text(1:1))
      case ("+")
        name = "passed"
      case ("-")
        name = "FAILED"
      case ("=")
        name = "stated"
      case default
        name = "      "
      end select
      write (output_unit, "(6a)") name, "  ", checks(i), "  ", text(2:)
    end do
  end subroutine check_case

  !> Run the load path of a case, and open the routine that is checked.
  subroutine find_path(case, path, message)
    type(case_type), intent(in) :: case                         !! the case
    type(path_type), intent(inout) :: path                      !! without durations on error
    character(len=:), allocatable, intent(out) :: message       !! verdict; empty: the whole path was run
    type(run_type) :: run
    type(row_type) :: row
    real(wp) :: s(3), share, time
    integer :: i, n
    logical :: found
    message = ""
    if (size(case%steps) == 0) then
      message = "a replay has no load path: expected &step"
      return
    end if
    s = 0.0_wp
    if (case%umat%given) then
      path%law = case%umat
      path%start = case%state%statev
    else
      path%law%library = ""
      path%law%symbol = "umat_"
      path%law%props = case%props
      path%law%nstatv = case%joint%n_statev
      path%law%first = spread(0.0_wp, 1, path%law%nstatv)
      if (case%state%given) path%law%first = case%state%statev
      call open_umat(path%law, case%joint%material%s0, max(case%joint%material%k_n, case%joint%material%k_t), message)
      path%start = path%law%virgin()
    end if
    if (case%state%given) s = case%state%s
    allocate (path%s(3, 1), path%step(0), path%increment(0))
    path%s(:, 1) = s
    if (case%state%given) then
      call start_run(case%joint, case%steps, run, new_point(law_of(case), case%state%statev, s), law_of(case))
    else
      call start_run(case%joint, case%steps, run, law=law_of(case))
    end if
    time = 0.0_wp
    allocate (path%dt(0))
    call run%law%ask(share, message)
    if (share <= 0.0_wp) message = "-" // message
    if (share <= 0.0_wp) return
    do
      call next_row(run, row, found)
      if (.not. found) exit
      if (row%lost) then
        message = ""
        call explain_loss(run, row, message)
        call run%law%ask(share, message)
        message = merge("-", "=", share <= 0.0_wp) // "ends after " // integer_text(size(path%dt)) // " increments: " // &
          message
        exit
      end if
      n = merge(2*row%report%parts, 1, row%cut)
      do i = 1, n
        path%dt = [path%dt, (row%time - time)/real(n, wp)]
        path%s = reshape([path%s, s + real(i, wp)/real(n, wp)*(row%s - s)], [3, size(path%dt) + 1])
        path%step = [path%step, row%step]
        path%increment = [path%increment, row%increment]
      end do
      time = row%time
      s = row%s
    end do
  end subroutine find_path

  !> Take a point over a share of increment i.
  subroutine go(law, path, shares, i, from, to, old, state, t, d)
    type(foreign_law), intent(inout) :: law        !! its attempts are counted
    type(path_type), intent(in) :: path            !! the path
    real(wp), intent(in) :: shares(3)              !! of the components of the path
    integer, intent(in) :: i                       !! increment
    real(wp), intent(in) :: from, to               !! 0 to 1
    real(wp), intent(in) :: old(:)                 !! state at the start
    real(wp), intent(out) :: state(:)              !! state at the end
    real(wp), intent(out) :: t(3), d(3, 3)         !! traction and tangent
    call point(law, path, i, shares*between(path, i, from), shares*between(path, i, to), (to - from)*path%dt(i), old, &
      state, t, d)
  end subroutine go

  !> Separation in increment i.
  pure function between(path, i, share) result(s)
    type(path_type), intent(in) :: path   !! the path
    integer, intent(in) :: i              !! increment
    real(wp), intent(in) :: share         !! 0 to 1
    real(wp) :: s(3)
    s = path%s(:, i) + share*(path%s(:, i + 1) - path%s(:, i))
    if (share >= 1.0_wp) s = path%s(:, i + 1)
  end function between

  !> Update a point in increment i.
  subroutine point(law, path, i, s_old, s, dt, old, state, t, d)
    type(foreign_law), intent(inout) :: law        !! its attempts are counted
    type(path_type), intent(in) :: path            !! the path
    integer, intent(in) :: i                       !! increment
    real(wp), intent(in) :: s_old(3), s(3)         !! separation at both ends
    real(wp), intent(in) :: dt                     !! duration
    real(wp), intent(in) :: old(:)                 !! state at the start
    real(wp), intent(out) :: state(:)              !! state at the end
    real(wp), intent(out) :: t(3), d(3, 3)         !! traction and tangent
    law%step = path%step(i)
    law%increment = path%increment(i)
    law%attempt = law%attempt + 1
    call law%update(s_old, s, old, state, t, d, dt, 0.0_wp)
  end subroutine point

  !> Go along a path, each increment in equal parts.
  subroutine walk(law, path, shares, parts, found)
    type(foreign_law), intent(inout) :: law        !! the law
    type(path_type), intent(in) :: path            !! the path
    real(wp), intent(in) :: shares(3)              !! of its components
    integer, intent(in) :: parts                   !! of an increment
    type(walk_type), intent(out) :: found          !! results
    real(wp) :: old(law%n_state)
    integer :: i, k, n
    n = size(path%dt)
    allocate (found%t(3, n), found%d(3, 3, n), found%state(law%n_state, 0:n))
    found%state(:, 0) = law%virgin()
    if (law%ntens == path%law%ntens) found%state(:, 0) = path%start
    do i = 1, n
      found%state(:, i) = found%state(:, i - 1)
      do k = 1, parts
        old = found%state(:, i)
        call go(law, path, shares, i, real(k - 1, wp)/real(parts, wp), real(k, wp)/real(parts, wp), old, &
          found%state(:, i), found%t(:, i), found%d(:, :, i))
      end do
    end do
    found%reason = failure(law)
  end subroutine walk

  !> Why a routine has failed; empty: it has not.
  function failure(law) result(reason)
    type(foreign_law), intent(in) :: law   !! the law
    character(len=:), allocatable :: reason
    real(wp) :: share
    reason = ""
    call law%ask(share, reason)
  end function failure

  !> Place of the first difference between two walks; empty: they are equal to the last bit.
  pure function unlike(a, b) result(place)
    type(walk_type), intent(in) :: a, b   !! results
    character(len=:), allocatable :: place
    integer :: i
    place = ""
    do i = 1, size(a%t, 2)
      if (any(abs(a%t(:, i) - b%t(:, i)) > 0.0_wp) .or. any(abs(a%d(:, :, i) - b%d(:, :, i)) > 0.0_wp) .or. &
        any(abs(a%state(:, i) - b%state(:, i)) > 0.0_wp)) then
        place = " from increment " // integer_text(i) // " of the path on"
        return
      end if
    end do
  end function unlike

  !> Make a check: its verdict (+ passed, - failed, = stated, ? not judged) and its text.
  subroutine judge(which, data, text) bind(c)
    integer(c_int), value :: which                           !! check, or an argument beyond the last check
    type(c_ptr), value :: data                               !! path
    character(kind=c_char), intent(inout) :: text(600)       !! verdict
    type(path_type), pointer :: path
    type(foreign_law) :: law
    type(walk_type) :: found
    character(len=:), allocatable :: verdict
    integer :: i
    call c_f_pointer(data, path)
    law = fresh_umat(path%law, .true.)
    verdict = "+"
    select case (which)
    case (1)
      call check_arguments(law, path, verdict)
    case (2, 3)
      call check_calls(law, path, which == 3, verdict)
    case (4)
      call check_alternating(law, path, verdict)
    case (5)
      call check_threads(law, path, verdict)
    case (6)
      call check_absent(law, path, all_absent, verdict)
    case (7)
      call check_components(law, path, verdict)
    case (8, 9)
      call walk(law, path, same, 1, found)
      if (which == 8) call check_tangent(law, path, found, verdict)
      if (which == 9) call check_symmetry(law, found, verdict)
    case (10, 11)
      call walk(law, path, same, merge(energy_parts, 1, which == 10), found)
      if (which == 10) call check_energies(path, found, verdict)
      if (which == 11) call check_dissipation(path, found, verdict)
    case default
      call check_absent(law, path, int(which) - size(checks), verdict)
    end select
    if (which > 1 .and. len(failure(law)) > 0) verdict = "?not judged: " // failure(law)
    do i = 1, min(len(verdict), size(text) - 1)
      text(i) = verdict(i:i)
    end do
  end subroutine judge

  !> Nothing is written or read outside the arguments, and those of the host do not change.
  subroutine check_arguments(law, path, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    type(walk_type) :: a, b
    call set_umat(law, .true., guard_nan, none_absent)
    call walk(law, path, same, 1, a)
    law = fresh_umat(law, .true.)
    call set_umat(law, .true., guard_one, none_absent)
    call walk(law, path, same, 1, b)
    if (len(a%reason) > 0) then
      verdict = "-" // a%reason
    else if (len(unlike(a, b)) > 0) then
      verdict = "-the results depend on what lies behind its arguments" // unlike(a, b)
    else
      verdict = "+nothing written or read outside its own"
    end if
  end subroutine check_arguments

  !> The same results if a call is repeated, and if an increment is tried as a whole before it is taken in halves.
  subroutine check_calls(law, path, cuts, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    logical, intent(in) :: cuts                                  !! whether increments are cut
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    type(walk_type) :: a, b
    real(wp) :: middle(law%n_state)
    integer :: i
    call walk(law, path, same, merge(2, 1, cuts), a)
    law = fresh_umat(law, .true.)
    b = a
    do i = 1, size(path%dt)
      call go(law, path, same, i, 0.0_wp, 1.0_wp, b%state(:, i - 1), middle, b%t(:, i), b%d(:, :, i))
      if (cuts) then
        call go(law, path, same, i, 0.0_wp, 0.5_wp, b%state(:, i - 1), middle, b%t(:, i), b%d(:, :, i))
        call go(law, path, same, i, 0.5_wp, 1.0_wp, middle, b%state(:, i), b%t(:, i), b%d(:, :, i))
      else
        call go(law, path, same, i, 0.0_wp, 1.0_wp, b%state(:, i - 1), b%state(:, i), b%t(:, i), b%d(:, :, i))
      end if
    end do
    verdict = "+the same " // trim(merge("after a larger increment that is tried first", &
      "when a call is repeated                     ", cuts))
    if (len(unlike(a, b)) > 0) verdict = "-other results " // trim(merge("after a larger increment that is tried first", &
      "when a call is repeated                     ", cuts)) // unlike(a, b)
  end subroutine check_calls

  !> The same results if two points alternate.
  subroutine check_alternating(law, path, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    type(walk_type) :: a, b, c, d
    integer :: i
    call walk(law, path, same, 1, a)
    law = fresh_umat(law, .true.)
    call walk(law, path, other, 1, b)
    law = fresh_umat(law, .true.)
    c = a
    d = b
    do i = 1, size(path%dt)
      call go(law, path, same, i, 0.0_wp, 1.0_wp, c%state(:, i - 1), c%state(:, i), c%t(:, i), c%d(:, :, i))
      call go(law, path, other, i, 0.0_wp, 1.0_wp, d%state(:, i - 1), d%state(:, i), d%t(:, i), d%d(:, :, i))
    end do
    verdict = "+two points in turn do not disturb each other"
    if (len(unlike(a, c)) > 0) verdict = "-other results beside another point" // unlike(a, c)
    if (len(unlike(b, d)) > 0) verdict = "-other results beside another point" // unlike(b, d)
  end subroutine check_alternating

  !> The same results from two threads.
  subroutine check_threads(law, path, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(inout), target :: path               !! the path; the laws of the threads are set
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    type(walk_type), target :: a, b
    call walk(law, path, same, 1, a)
    law = fresh_umat(law, .true.)
    call walk(law, path, other, 1, b)
    law = fresh_umat(law, .true.)
    path%own(1) = fresh_umat(law, .false.)
    path%own(2) = fresh_umat(law, .false.)
    path%first = c_loc(a)
    path%second = c_loc(b)
    call c_threads(c_funloc(walk_often), c_loc(path))
    verdict = "+the same from two threads"
    if (.not. all(path%same)) verdict = "-other results from two threads"
  end subroutine check_threads

  !> Go along the path of a thread many times, and compare.
  subroutine walk_often(which, data) bind(c)
    integer(c_int), value :: which   !! thread, 1 or 2
    type(c_ptr), value :: data       !! path
    !> Updates of a thread, so that both work at the same time.
    integer, parameter :: updates = 20000
    type(path_type), pointer :: path
    type(walk_type), pointer :: alone
    type(walk_type) :: found
    integer :: i
    call c_f_pointer(data, path)
    if (which == 1) then
      call c_f_pointer(path%first, alone)
    else
      call c_f_pointer(path%second, alone)
    end if
    do i = 1, 1 + updates/size(path%dt)
      call walk(path%own(which), path, merge(same, other, which == 1), 1, found)
      path%same(which) = path%same(which) .and. len(unlike(found, alone)) == 0
    end do
  end subroutine walk_often

  !> The same results if arguments that hosts may not have are NULL.
  subroutine check_absent(law, path, absent, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    integer, intent(in) :: absent                                !! which
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    type(walk_type) :: a, b
    call walk(law, path, same, 1, a)
    call set_umat(law, .false., guard_nan, absent)
    call walk(law, path, same, 1, b)
    verdict = "+arguments that hosts may not have can be NULL"
    if (len(unlike(a, b)) > 0) verdict = "-other results if arguments that hosts may not have are NULL" // unlike(a, b)
  end subroutine check_absent

  !> The same results with 2, 3 and 6 components; without Ty for 2.
  subroutine check_components(law, path, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    integer, parameter :: ntens(3) = [3, 2, 6], positions(3, 3) = reshape([1, 2, 3, 1, 2, 0, 3, 5, 6], [3, 3])
    type(walk_type) :: found(3)
    real(wp) :: error
    integer :: i, n
    do i = 1, 3
      law%ntens = ntens(i)
      law%position = positions(:, i)
      law%n_state = n_header + law%ntens + law%nstatv
      call walk(law, path, [1.0_wp, 1.0_wp, 0.0_wp], 1, found(i))
      if (len(found(i)%reason) > 0) then
        verdict = "?not judged: with NTENS = " // integer_text(ntens(i)) // ": " // found(i)%reason
        law = fresh_umat(path%law, .false.)
        return
      end if
      n = merge(2, 3, ntens(i) == 2)
      error = max(maxval(abs(found(i)%t(:n, :) - found(1)%t(:n, :)))/law%stress, &
        maxval(abs(found(i)%d(:n, :n, :) - found(1)%d(:n, :n, :)))/law%stiffness)
      if (error <= component_error) cycle
      verdict = "-NTENS = " // integer_text(ntens(i)) // " differs from 3 by " // short(error) // &
        " of strength or stiffness (order 33, 13, 23 of 6)"
      return
    end do
    verdict = "+the same with NTENS = 2, 3 and 6"
  end subroutine check_components

  !> DDSDDE beside central differences. Where those from both sides differ, there is a kink, which is named.
  subroutine check_tangent(law, path, walked, verdict)
    type(foreign_law), intent(inout) :: law                      !! the law
    type(path_type), intent(in) :: path                          !! the path
    type(walk_type), intent(in) :: walked                        !! results along it
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    real(wp), dimension(law%n_state) :: higher, lower
    real(wp) :: a(3), b(3), error, h, ignored(3, 3), move(3), unit
    integer :: at(2), contacts, first, i, j, k, kinks, loadings, wrong
    contacts = 0
    loadings = 0
    kinks = 0
    wrong = 0
    first = 0
    at = 1
    error = 0.0_wp
    h = difference*law%length
    do i = 1, size(path%dt)
      unit = max(law%stiffness, maxval(abs(walked%d(:, :, i))))
      do j = 1, 3
        if (law%position(j) == 0) cycle
        move = 0.0_wp
        move(j) = h
        call point(law, path, i, path%s(:, i), path%s(:, i + 1) + move, path%dt(i), walked%state(:, i - 1), higher, a, &
          ignored)
        call point(law, path, i, path%s(:, i), path%s(:, i + 1) - move, path%dt(i), walked%state(:, i - 1), lower, b, &
          ignored)
        associate (d => walked%d(:, j, i), t => walked%t(:, i))
          if (maxval(abs((a - b)/(2.0_wp*h) - d)) <= tangent_error*unit) cycle
          if (maxval(abs(a - 2.0_wp*t + b))/h > kink*unit) then
            k = n_header + law%ntens + 1
            kinks = kinks + 1
            if (abs(path%s(1, i + 1)) <= h) then
              contacts = contacts + 1
            else if (changed(higher(k:), walked%state(k:, i - 1)) .neqv. changed(lower(k:), walked%state(k:, i - 1))) then
              loadings = loadings + 1
            end if
            cycle
          end if
          wrong = wrong + 1
          if (maxval(abs((a - b)/(2.0_wp*h) - d))/unit <= error) cycle
          k = maxloc(abs((a - b)/(2.0_wp*h) - d), 1)
          error = abs((a(k) - b(k))/(2.0_wp*h) - d(k))/unit
          first = i
          at = [k, j]
        end associate
      end do
    end do
    verdict = "+that of central differences"
    if (wrong > 0) verdict = "-d t_" // trim(component_names(at(1))) // "/d s_" // trim(component_names(at(2))) // &
      " differs from central differences by " // short(error) // " of the stiffness in step " // &
      integer_text(path%step(first)) // " increment " // integer_text(path%increment(first)) // "; " // &
      integer_text(wrong) // " columns differ"
    if (kinks > 0) verdict = verdict // "; not differenced: " // integer_text(kinks) // " columns at kinks (" // &
      integer_text(loadings) // " between loading and unloading, " // integer_text(contacts) // &
      " at the contact, " // integer_text(kinks - loadings - contacts) // " others)"
    if (kinks >= size(path%dt)*count(law%position > 0)) verdict(1:1) = "-"
  end subroutine check_tangent

  !> Whether two lists differ.
  pure function changed(a, b) result(yes)
    real(wp), intent(in) :: a(:), b(:)   !! of the same size
    logical :: yes
    yes = any(abs(a - b) > 0.0_wp)
  end function changed

  !> State how far the tangent is from symmetric.
  subroutine check_symmetry(law, walked, verdict)
    type(foreign_law), intent(in) :: law                         !! the law
    type(walk_type), intent(in) :: walked                        !! results along the path
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    real(wp) :: largest
    integer :: i
    largest = 0.0_wp
    do i = 1, size(walked%t, 2)
      largest = max(largest, maxval(abs(walked%d(:, :, i) - transpose(walked%d(:, :, i))))/law%stiffness)
    end do
    verdict = "=DDSDDE is symmetric"
    if (largest > rounding) verdict = "=DDSDDE is not symmetric, by up to " // short(largest) // &
      " of the stiffness: use the unsymmetric solver"
  end subroutine check_symmetry

  !> The work of the traction is the sum of the energies.
  subroutine check_energies(path, walked, verdict)
    type(path_type), intent(in) :: path                          !! the path
    type(walk_type), intent(in) :: walked                        !! results in small parts
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    real(wp) :: error, sums(0:size(path%dt)), work(0:size(path%dt))
    integer :: i
    sums = sum(walked%state([v_stored, v_rupture, v_friction], :), 1)
    work = walked%state(u_work, :) - walked%state(u_work, 0)
    error = maxval(abs(work - (sums - sums(0))))
    i = maxloc(abs(work - (sums - sums(0))), 1) - 1
    if (.not. any(abs(sums) > 0.0_wp)) then
      verdict = "-SSE, SPD and SCD are zero: the host knows no energies of this law"
    else if (error > energy_error*maxval(abs(work))) then
      verdict = "-at step " // integer_text(path%step(max(1, i))) // " increment " // &
        integer_text(path%increment(max(1, i))) // " the work is " // short(work(i)) // ", SSE + SPD + SCD " // &
        short(sums(i) - sums(0))
    else
      verdict = "+work = SSE + SPD + SCD within " // short(error/max(maxval(abs(work)), tiny(error))) // &
        " of the largest work"
    end if
  end subroutine check_energies

  !> What is dissipated never decreases.
  subroutine check_dissipation(path, walked, verdict)
    type(path_type), intent(in) :: path                          !! the path
    type(walk_type), intent(in) :: walked                        !! results along it
    character(len=:), allocatable, intent(inout) :: verdict      !! the verdict
    real(wp) :: change, spent(0:size(path%dt))
    integer :: i
    spent = sum(walked%state([v_rupture, v_friction], :), 1)
    verdict = "+SPD + SCD never decrease"
    if (.not. any(abs(spent) > 0.0_wp)) verdict = "?not judged: SPD and SCD are zero"
    do i = 1, size(path%dt)
      change = spent(i) - spent(i - 1)
      if (change >= -rounding*maxval(abs(spent))) cycle
      verdict = "-SPD + SCD decrease by " // short(-change) // " in step " // integer_text(path%step(i)) // &
        " increment " // integer_text(path%increment(i))
      exit
    end do
  end subroutine check_dissipation

end module check_umat
