!> Checks of a UMAT along the load path of a case, each in a process of its own with the library loaded again: a table
!> of what passed and what failed.
module check_umat
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_loc, c_null_char, c_ptr
  use, intrinsic :: iso_fortran_env, only: output_unit
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_control_point, only: ended_rejected, new_point
  use asperity_kinds, only: wp
  use asperity_load_path, only: explain_loss, next_row, row_type, run_type, start_run
  use asperity_point_law, only: point_law
  use asperity_steps, only: component_names
  use asperity_text, only: integer_text, short
  use case_file, only: case_type, get_law
  use driver_messages, only: exit_input, exit_ok, say
  use foreign_umat, only: c_text, foreign_law, fresh_umat, guard_one, n_header, open_umat, u_work
  implicit none
  private
  public :: check_case

  !> Checks in their order, the load path before them; from `first_judged` on they are of no meaning if a routine has
  !> hidden state.
  character(len=*), parameter :: checks(0:11) = [character(len=12) :: "path", "arguments", "repeated", "cut", &
    "alternating", "threads", "absent", "components", "tangent", "symmetry", "energies", "dissipation"]
  integer, parameter :: first_hidden = 2, first_judged = 6
  !> Step of a difference, relative to `length`; largest error of DDSDDE and, at a kink, of a one-sided difference,
  !> relative to the stiffness; largest error of the energies, relative to the largest work, with each increment in
  !> parts; what is a rounding error, and that of a result with another number of components.
  real(wp), parameter :: difference = 1.0e-5_wp, tangent_error = 1.0e-5_wp, kink = 1.0e-3_wp, energy_error = 0.01_wp, &
    rounding = 1.0e-9_wp, component_error = 1.0e-12_wp
  integer, parameter :: energy_parts = 16
  !> Updates of a thread, so that both work at the same time.
  integer, parameter :: thread_updates = 20000
  !> The second point moves by these shares of the path.
  real(wp), parameter :: other(3) = [0.6_wp, -0.6_wp, 0.3_wp], same(3) = 1.0_wp
  integer, parameter :: text_length = 600

  !> The path that the checks go along.
  type :: path_type
    type(foreign_law) :: law
    real(wp), allocatable :: s(:, :)                      !! (3, 0:n) separation
    real(wp), allocatable :: dt(:)                        !! (n) durations
    integer, allocatable :: step(:), increment(:)         !! (n)
    real(wp), allocatable :: start(:)                     !! state at the start
    real(wp), allocatable :: alone(:, :, :)               !! results of both points, each in one thread
    logical :: alike(2) = .true.                          !! whether both have the same in two threads
  end type path_type

  interface
    !> Work in a process of its own.
    function c_apart(work, which, data, text, length) bind(c, name="umat_apart") result(signal)
      import :: c_char, c_funptr, c_int, c_ptr
      implicit none
      type(c_funptr), value :: work
      integer(c_int), value :: which, length
      type(c_ptr), value :: data
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
    type(path_type), target :: path
    character(kind=c_char) :: buffer(text_length)
    character(len=:), allocatable :: text
    logical :: hidden
    integer :: i, k

    code = exit_input
    if (size(case%steps) == 0) then
      call say(label // ": a replay has no load path: expected &step")
      return
    end if
    call find_path(case, path, text)
    code = exit_ok
    hidden = .false.
    write (output_unit, "(6a)") label, ": ", path%law%symbol, merge(" of ", "    ", len(path%law%library) > 0), &
      path%law%library
    do i = 0, ubound(checks, 1)
      if (i > 0 .and. size(path%dt) == 0) exit
      if (hidden .and. i >= first_judged) then
        text = "?not judged, as results depend on earlier calls"
      else if (i > 0) then
        buffer = c_null_char
        k = c_apart(c_funloc(judge), int(i, c_int), c_loc(path), buffer, text_length)
        text = c_text(buffer)
        if (k > 0) text = "-it ended by signal " // integer_text(k) // text
        ! without a verdict it has ended this process with the exit code 0
        if (k < 0 .or. k == 0 .and. scan(text, "+-=?") /= 1) text = "-it ended the program" // text
      end if
      if (text(1:1) == "-") code = exit_input
      hidden = hidden .or. (text(1:1) == "-" .and. i >= first_hidden .and. i < first_judged)
      k = index("+-=", text(1:1))
      write (output_unit, "(6a)") merge("passed", merge("FAILED", merge("stated", "      ", k == 3), k == 2), k == 1), &
        "  ", checks(i), "  ", text(2:)
    end do
  end subroutine check_case

  !> Run the load path of a case, and open the routine that is checked.
  subroutine find_path(case, path, verdict)
    type(case_type), intent(in) :: case                         !! the case
    type(path_type), intent(inout) :: path                      !! the path as far as it goes
    character(len=:), allocatable, intent(out) :: verdict       !! whether it was run
    class(point_law), allocatable :: law
    type(run_type) :: run
    type(row_type) :: row
    real(wp) :: s(3), share, time
    integer :: i, n
    logical :: found
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
      associate (m => case%joint%material)
        call open_umat(path%law, m%s0, max(m%k_n, m%k_t), verdict)
      end associate
      path%start = path%law%virgin()
    end if
    call get_law(case, law)
    if (case%state%given) then
      s = case%state%s
      call start_run(law, case%steps, run, new_point(law, case%state%statev, s))
    else
      call start_run(law, case%steps, run, new_point(law))
    end if
    allocate (path%s(3, 1), path%dt(0), path%step(0), path%increment(0))
    path%s(:, 1) = s
    time = 0.0_wp
    verdict = ""
    call run%law%ask(share, verdict)
    do while (share > 0.0_wp)
      call next_row(run, row, found)
      if (.not. found .or. row%lost) exit
      ! the routine has asked for smaller increments
      n = merge(2*row%report%parts, 1, row%report%cut)
      do i = 1, n
        path%dt = [path%dt, (row%time - time)/real(n, wp)]
        path%s = reshape([path%s, s + real(i, wp)/real(n, wp)*(row%s - s)], [3, size(path%dt) + 1])
        path%step = [path%step, row%step]
        path%increment = [path%increment, row%increment]
      end do
      time = row%time
      s = row%s
    end do
    if (row%lost) then
      call explain_loss(run, row, verdict)
      call run%law%ask(share, verdict)
    end if
    if (len(verdict) > 0) verdict = ", then " // verdict
    share = merge(0.0_wp, share, size(path%dt) == 0 .or. row%report%ended == ended_rejected)
    verdict = merge("-", merge("=", "+", row%lost), share <= 0.0_wp) // integer_text(size(path%dt)) // &
      " increments" // verdict
  end subroutine find_path

  !> Results along a path, each increment in equal parts: traction, tangent and state.
  subroutine walk(law, path, shares, parts, found)
    type(foreign_law), intent(inout) :: law                   !! its attempts are counted
    type(path_type), intent(in) :: path                       !! the path
    real(wp), intent(in) :: shares(3)                         !! of its components
    integer, intent(in) :: parts                              !! of an increment
    real(wp), allocatable, intent(out) :: found(:, :)         !! (12 + n_state, 0:n)
    integer :: i, k
    allocate (found(12 + law%n_state, 0:size(path%dt)))
    found(:, 0) = 0.0_wp
    found(13:, 0) = law%virgin()
    if (law%ntens == path%law%ntens) found(13:, 0) = path%start
    do i = 1, size(path%dt)
      found(:, i) = found(:, i - 1)
      do k = 1, parts
        found(:, i) = after(law, path, i, shares, real([k - 1, k], wp)/real(parts, wp), found(13:, i))
      end do
    end do
  end subroutine walk

  !> Results after a part of an increment.
  function after(law, path, i, shares, part, old, move) result(found)
    type(foreign_law), intent(inout) :: law               !! its attempts are counted
    type(path_type), intent(in) :: path                   !! the path
    integer, intent(in) :: i                              !! increment
    real(wp), intent(in) :: shares(3)                     !! of the components of the path
    real(wp), intent(in) :: part(2)                       !! start and end, 0 to 1
    real(wp), intent(in) :: old(:)                        !! state at the start
    real(wp), intent(in), optional :: move(3)             !! added to the separation at the end
    real(wp) :: found(12 + size(old))
    real(wp) :: d(3, 3), s(3, 2), state(size(old))
    integer :: k
    do k = 1, 2
      s(:, k) = shares*(path%s(:, i) + part(k)*(path%s(:, i + 1) - path%s(:, i)))
      if (part(k) >= 1.0_wp) s(:, k) = shares*path%s(:, i + 1)
    end do
    if (present(move)) s(:, 2) = s(:, 2) + move
    law%step = path%step(i)
    law%increment = path%increment(i)
    law%attempt = law%attempt + 1
    call law%update(s(:, 1), s(:, 2), old, state, found(:3), d, (part(2) - part(1))*path%dt(i), 0.0_wp)
    found(4:12) = reshape(d, [9])
    found(13:) = state
  end function after

  !> Go along the path of a thread many times, and compare.
  subroutine walk_often(which, data) bind(c)
    integer(c_int), value :: which   !! thread, 1 or 2
    type(c_ptr), value :: data       !! path
    type(path_type), pointer :: path
    type(foreign_law) :: law
    real(wp), allocatable :: found(:, :)
    integer :: i
    call c_f_pointer(data, path)
    law = fresh_umat(path%law, .false.)
    do i = 1, 1 + thread_updates/size(path%dt)
      call walk(law, path, merge(same, other, which == 1), 1, found)
      path%alike(which) = path%alike(which) .and. .not. any(abs(found - path%alone(:, :, which)) > 0.0_wp)
    end do
  end subroutine walk_often

  !> Make a check: its verdict (+ passed, - failed, = stated, ? not judged) and its text.
  subroutine judge(which, data, text) bind(c)
    integer(c_int), value :: which                              !! check
    type(c_ptr), value :: data                                  !! path
    character(kind=c_char), intent(inout) :: text(text_length)  !! verdict
    type(path_type), pointer :: path
    type(foreign_law) :: law
    real(wp), allocatable :: a(:, :), b(:, :), c(:, :), d(:, :)
    real(wp), allocatable, dimension(:) :: sums, work
    character(len=:), allocatable :: name, verdict
    real(wp) :: share
    integer :: i, n
    call c_f_pointer(data, path)
    n = size(path%dt)
    allocate (sums(n + 1), work(n + 1))
    law = fresh_umat(path%law, .true.)
    call walk(law, path, same, merge(energy_parts, 1, checks(which) == "energies"), a)
    select case (checks(which))
    case ("arguments")
      law = fresh_umat(law, .true., strict=.true.)
      call walk(law, path, same, 1, a)
      name = failure()
      law = fresh_umat(law, .true., strict=.true., guard=guard_one)
      call walk(law, path, same, 1, b)
      verdict = compared("with other numbers behind the arguments", "nothing written or read outside its own", a, b)
      if (len(name) > 0) verdict = "-" // name
    case ("repeated")
      law = fresh_umat(law, .true.)
      b = a
      do i = 1, n
        b(:, i) = after(law, path, i, same, [0.0_wp, 1.0_wp], b(13:, i - 1))
        b(:, i) = after(law, path, i, same, [0.0_wp, 1.0_wp], b(13:, i - 1))
      end do
      verdict = compared("when a call is repeated", "the same when a call is repeated", a, b)
    case ("cut")
      law = fresh_umat(law, .true.)
      call walk(law, path, same, 2, a)
      law = fresh_umat(law, .true.)
      b = a
      do i = 1, n
        b(:, i) = after(law, path, i, same, [0.0_wp, 1.0_wp], b(13:, i - 1))
        b(:, i) = after(law, path, i, same, [0.0_wp, 0.5_wp], b(13:, i - 1))
        b(:, i) = after(law, path, i, same, [0.5_wp, 1.0_wp], b(13:, i))
      end do
      verdict = compared("after a larger increment", "the same after a larger increment that is tried first", a, b)
    case ("alternating")
      law = fresh_umat(law, .true.)
      call walk(law, path, other, 1, b)
      law = fresh_umat(law, .true.)
      c = a
      d = b
      do i = 1, n
        c(:, i) = after(law, path, i, same, [0.0_wp, 1.0_wp], c(13:, i - 1))
        d(:, i) = after(law, path, i, other, [0.0_wp, 1.0_wp], d(13:, i - 1))
      end do
      verdict = compared("beside another point", "two points in turn do not disturb each other", a, c, b, d)
    case ("threads")
      law = fresh_umat(law, .true.)
      call walk(law, path, other, 1, b)
      path%alone = reshape([a, b], [size(a, 1), size(a, 2), 2])
      path%law = fresh_umat(law, .true.)
      call c_threads(c_funloc(walk_often), data)
      verdict = trim(merge("+the same from two threads     ", "-other results from two threads", all(path%alike)))
    case ("absent")
      i = 0
      do
        law = fresh_umat(law, .false., absent=i, name=name)
        if (len(name) == 0) exit
        call say_to(text, ": it uses " // name // ", which hosts may not have")
        call walk(law, path, same, 1, b)
        verdict = compared("if " // name // " is NULL", "arguments that hosts may not have can be NULL", a, b)
        if (verdict(1:1) == "-") exit
        i = i + 1
      end do
    case ("components")
      call check_components()
    case ("tangent")
      call check_tangent()
    case ("symmetry")
      share = 0.0_wp
      do i = 1, n
        share = max(share, maxval(abs(a([5, 6, 9], i) - a([7, 10, 11], i)))/law%stiffness)
      end do
      verdict = "=DDSDDE is symmetric"
      if (share > rounding) verdict = "=DDSDDE is not symmetric, by up to " // short(share) // &
        " of the stiffness: use the unsymmetric solver"
    case ("energies")
      sums(:) = sum(a(12 + [v_stored, v_rupture, v_friction], :), 1)
      sums(:) = sums - sums(1)
      work(:) = a(12 + u_work, :) - a(12 + u_work, 0)
      i = maxloc(abs(work - sums), 1)
      share = abs(work(i) - sums(i))/max(maxval(abs(work)), tiny(share))
      verdict = "+work = SSE + SPD + SCD within " // short(share) // " of the largest work"
      if (share > energy_error) verdict = "-" // place(i - 1) // "the work is " // &
        short(work(i)) // ", SSE + SPD + SCD " // short(sums(i))
      if (.not. any(abs(sums) > 0.0_wp)) verdict = "-SSE, SPD and SCD are zero: the host knows no energies of this law"
    case ("dissipation")
      sums(:) = sum(a(12 + [v_rupture, v_friction], :), 1)
      work(:n) = sums(2:) - sums(:n)
      i = minloc(work(:n), 1)
      verdict = "+SPD + SCD never decrease"
      if (.not. any(abs(sums) > 0.0_wp)) verdict = "?not judged: SPD and SCD are zero"
      if (work(i) < -rounding*maxval(abs(sums))) verdict = "-" // place(i) // "SPD + SCD decrease by " // &
        short(-work(i))
    case default
      verdict = "?no such check"
    end select
    name = failure()
    if (which > 1 .and. len(name) > 0) verdict = trim(merge("-            ", "?not judged: ", &
      checks(which) == "repeated")) // " " // name
    call say_to(text, verdict)

  contains

    !> Why the routine has failed; empty: it has not.
    function failure() result(reason)
      character(len=:), allocatable :: reason
      reason = ""
      call law%ask(share, reason)
    end function failure

    !> Step and increment of the case.
    function place(j) result(text_of_place)
      integer, intent(in) :: j   !! increment of the path
      character(len=:), allocatable :: text_of_place
      text_of_place = "in step " // integer_text(path%step(max(1, j))) // " increment " // &
        integer_text(path%increment(max(1, j))) // " "
    end function place

    !> Verdict on results that must be equal to the last bit.
    function compared(doubt, praise, x, y, z, w) result(found)
      character(len=*), intent(in) :: doubt, praise           !! when they differ, and if they are equal
      real(wp), intent(in) :: x(:, 0:), y(:, 0:)              !! results
      real(wp), intent(in), optional :: z(:, 0:), w(:, 0:)    !! further results
      character(len=:), allocatable :: found
      integer :: j
      found = "+" // praise
      do j = n, 1, -1
        if (any(abs(x(:, j) - y(:, j)) > 0.0_wp)) found = "-other results " // doubt // ", first " // place(j)
      end do
      if (present(z) .and. found(1:1) == "+") found = compared(doubt, praise, z, w)
    end function compared

    !> The same results with 2, 3 and 6 components; without Ty for 2.
    subroutine check_components()
      integer, parameter :: ntens(3) = [3, 2, 6], places(3, 3) = reshape([1, 2, 3, 1, 2, 0, 3, 5, 6], [3, 3])
      integer, parameter :: of_two(6) = [1, 2, 4, 5, 7, 8]
      real(wp) :: unit(12)
      unit = [spread(law%stress, 1, 3), spread(law%stiffness, 1, 9)]
      verdict = "+the same with NTENS = 2, 3 and 6"
      i = findloc(ntens, law%ntens, dim=1)
      if (any(law%position /= places(:, i))) verdict = "?not judged: expected order = 'N,Tx', 'N,Tx,Ty' or " // &
        "'-,-,N,-,Tx,Ty'"
      if (verdict(1:1) == "?") return
      do i = 1, 3
        law%ntens = ntens(i)
        law%position = places(:, i)
        law%n_state = n_header + law%ntens + law%nstatv
        call walk(law, path, [1.0_wp, 1.0_wp, 0.0_wp], 1, b)
        name = failure()
        if (len(name) > 0) verdict = "?not judged: with NTENS = " // integer_text(ntens(i)) // ": " // name
        if (len(name) > 0) law = fresh_umat(path%law, .false.)
        if (len(name) > 0) return
        if (i == 1) a = b
        share = 0.0_wp
        if (i == 2) share = maxval(abs(a(of_two, :) - b(of_two, :))/spread(unit(of_two), 2, n + 1))
        if (i == 3) share = maxval(abs(a(:12, :) - b(:12, :))/spread(unit, 2, n + 1))
        if (share > component_error) verdict = "-NTENS = " // integer_text(ntens(i)) // " differs from 3 by " // &
          short(share) // " of strength or stiffness (33, 13, 23 of 6)"
      end do
    end subroutine check_components

    !> DDSDDE beside central differences. Where those from both sides differ, there is a kink, which is named.
    subroutine check_tangent()
      real(wp), dimension(12 + law%n_state) :: higher, lower
      real(wp), parameter :: steps(2) = difference*[1.0_wp, 0.01_wp]
      real(wp) :: error(3), errors(3), h, largest, move(3), unit
      integer :: contacts, j, k, kinks, loadings, statev, wrong
      logical :: kinked
      contacts = 0
      loadings = 0
      kinks = 0
      wrong = 0
      largest = 0.0_wp
      statev = 13 + n_header + law%ntens
      do i = 1, n
        unit = max(law%stiffness, maxval(abs(a(4:12, i))))
        do j = 1, 3
          if (law%position(j) == 0) cycle
          do k = 1, 2
            h = steps(k)*law%length
            move = 0.0_wp
            move(j) = h
            higher = after(law, path, i, same, [0.0_wp, 1.0_wp], a(13:, i - 1), move)
            lower = after(law, path, i, same, [0.0_wp, 1.0_wp], a(13:, i - 1), -move)
            errors = abs((higher(:3) - lower(:3))/(2.0_wp*h) - a(3*j + 1:3*j + 3, i))/unit
            ! where both sides are alike, kinks and jumps on both cancel: a shorter step is beside the kinks, and the
            ! error of a jump grows with it
            kinked = maxval(abs(higher(:3) - 2.0_wp*a(:3, i) + lower(:3))) > h*unit*min(kink, maxval(errors))
            if (k == 2) kinked = kinked .or. maxval(errors) > 0.5_wp*steps(1)/steps(2)*maxval(error)
            if (k == 1 .or. maxval(errors) <= tangent_error) error = errors
            if (kinked .or. maxval(error) <= tangent_error) exit
          end do
          if (maxval(error) <= tangent_error) cycle
          if (kinked) then
            kinks = kinks + 1
            if (abs(path%s(1, i + 1)) <= h) then
              contacts = contacts + 1
            else if (any(abs(higher(statev:) - a(statev:, i - 1)) > 0.0_wp) .neqv. &
              any(abs(lower(statev:) - a(statev:, i - 1)) > 0.0_wp)) then
              loadings = loadings + 1
            end if
            cycle
          end if
          wrong = wrong + 1
          if (maxval(error) > largest) verdict = "-" // place(i) // "d t_" // &
            trim(component_names(maxloc(error, 1))) // "/d s_" // trim(component_names(j)) // &
            " differs from differences by " // short(maxval(error)) // " of the stiffness; columns that differ: "
          largest = max(largest, maxval(error))
        end do
      end do
      if (wrong > 0) verdict = verdict // integer_text(wrong)
      if (wrong == 0) verdict = merge("-", "+", kinks >= n*count(law%position > 0)) // "that of central differences"
      if (kinks > 0) verdict = verdict // "; not differenced: " // integer_text(kinks) // " columns at kinks (" // &
        integer_text(loadings) // " between loading and unloading, " // integer_text(contacts) // &
        " at s_N = 0, " // integer_text(kinks - loadings - contacts) // " others)"
    end subroutine check_tangent

  end subroutine judge

  !> Write a text for the process that waits.
  subroutine say_to(text, said)
    character(kind=c_char), intent(inout) :: text(text_length)   !! shared with that process
    character(len=*), intent(in) :: said                         !! cut if it is too long
    integer :: i
    text = c_null_char
    do i = 1, min(len(said), text_length - 1)
      text(i) = said(i:i)
    end do
  end subroutine say_to

end module check_umat
