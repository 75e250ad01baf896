!> Checks of a UMAT along a load path, as a table. Each walk along the path is made in a child of its own, which opens
!> the library anew; what a child sends is judged here.
module asperity_umat_checks
  use, intrinsic :: iso_c_binding, only: c_char, c_f_pointer, c_funloc, c_funptr, c_int, c_loc, c_ptr
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_foreign_umat, only: absent_name, call_type, foreign_law, n_header, open_umat, u_work
  use asperity_kinds, only: wp
  use asperity_steps, only: component_names
  use asperity_text, only: integer_text, short
  use asperity_umat_worker, only: end_worker, receive_row, send_row, start_worker, worker_type
  implicit none
  private
  public :: check_umat, add_increment

  !> Outcomes of a check.
  character(len=*), parameter, public :: passed = "passed", failed = "FAILED", stated = "stated", &
    not_judged = "not judged", not_declared = "not declared"
  !> Checks in their order; from `first_judged` on they are of no meaning if a UMAT has hidden state.
  character(len=*), parameter, public :: check_names(11) = [character(len=12) :: "arguments", "repeated", "cut", &
    "alternating", "threads", "absent", "components", "tangent", "symmetry", "energies", "dissipation"]
  integer, parameter :: first_hidden = 2, first_judged = 6
  !> Step of a difference, relative to `length`; largest error of DDSDDE and, at a kink, of a one-sided difference,
  !> relative to the stiffness; largest error of the energies, relative to the largest work, with each increment in
  !> parts; what is a rounding error, and that of a result with another number of components.
  real(wp), parameter :: difference(2) = 1.0e-5_wp*[1.0_wp, 0.01_wp], tangent_error = 1.0e-5_wp, kink = 1.0e-3_wp, &
    energy_error = 0.01_wp, rounding = 1.0e-9_wp, component_error = 1.0e-12_wp
  integer, parameter :: energy_parts = 16
  !> Updates of a thread, so that both work at the same time.
  integer, parameter :: thread_updates = 20000
  !> The second point moves by these factors of the components.
  real(wp), parameter :: other(3) = [0.6_wp, -0.6_wp, 0.3_wp], same(3) = 1.0_wp
  !> Traction and tangent before the state in a result; numbers of the differences at an increment.
  integer, parameter :: n_first = 12, n_differences = 48
  !> Kinds of walks along the path: one point, which may try each increment before, two points in turn or in two
  !> threads, and differences of the traction at each increment.
  integer, parameter :: alone = 1, trying = 2, with_other = 3, in_threads = 4, with_differences = 5

  !> A row of the table.
  type, public :: check_type
    character(len=12) :: name = ""           !! of the check
    character(len=12) :: outcome = passed
    character(len=:), allocatable :: text    !! what was found
    real(wp) :: measured = 0.0_wp            !! what is compared with the limit
    real(wp) :: limit = -1.0_wp              !! below 0: the check has none
  end type check_type

  !> The path that the checks go along.
  type, public :: checked_path_type
    type(foreign_law) :: law
    real(wp), allocatable :: s(:, :)                      !! (3, 0:n) separation
    real(wp), allocatable :: dt(:)                        !! (n) durations
    integer, allocatable :: step(:), increment(:)         !! (n)
    real(wp), allocatable :: start(:)                     !! state at the start
  end type checked_path_type

  !> A walk along it.
  type :: walk_type
    type(checked_path_type) :: path
    type(call_type) :: how
    integer :: kind = alone
    integer :: parts = 1                     !! of an increment
    real(wp) :: factors(3) = same            !! of the components of the path
    real(wp), allocatable :: known(:, :, :)  !! results of both points, each alone, or of one
    integer :: differs(2) = huge(1)          !! first increment with other results in two threads
  end type walk_type

  interface
    !> Two pieces of work at once.
    subroutine c_threads(work, data) bind(c, name="umat_threads")
      import :: c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: work
      type(c_ptr), value :: data
    end subroutine c_threads
  end interface

contains

  !> Add an increment to a path, in equal parts.
  pure subroutine add_increment(path, s, dt, step, increment, parts)
    type(checked_path_type), intent(inout) :: path   !! the path, with its first separation
    real(wp), intent(in) :: s(3)                     !! separation at the end
    real(wp), intent(in) :: dt                       !! duration
    integer, intent(in) :: step, increment           !! numbers of the case
    integer, intent(in) :: parts                     !! from 1
    real(wp) :: from(3)
    integer :: i
    from = path%s(:, size(path%dt) + 1)
    do i = 1, parts
      path%dt = [path%dt, dt/real(parts, wp)]
      path%s = reshape([path%s, from + real(i, wp)/real(parts, wp)*(s - from)], [3, size(path%dt) + 1])
      path%step = [path%step, step]
      path%increment = [path%increment, increment]
    end do
  end subroutine add_increment

  !> Make the checks of a UMAT.
  subroutine check_umat(path, checks)
    type(checked_path_type), intent(in) :: path            !! the path
    type(check_type), intent(out) :: checks(:)             !! in the order of check_names
    real(wp), allocatable :: a(:, :)
    character(len=:), allocatable :: failure
    logical :: hidden
    integer :: i
    hidden = .false.
    call walk(walk_type(path=path, how=call_type()), a, failure)
    do i = 1, size(check_names)
      checks(i)%name = check_names(i)
      if (size(path%dt) == 0) then
        call judge(checks(i), not_judged, "the path has no increment")
      else if (hidden .and. i >= first_judged) then
        call judge(checks(i), not_judged, "results depend on earlier calls")
      else if (len(failure) > 0 .and. i > 1) then
        call judge(checks(i), not_judged, failure)
      else
        call make_check(path, a, checks(i))
      end if
      hidden = hidden .or. (checks(i)%outcome == failed .and. i >= first_hidden .and. i < first_judged)
    end do
  end subroutine check_umat

  !> Set outcome and text of a check.
  subroutine judge(check, outcome, text)
    type(check_type), intent(inout) :: check   !! the check
    character(len=*), intent(in) :: outcome    !! one of the five
    character(len=*), intent(in) :: text       !! what was found
    check%outcome = outcome
    check%text = text
  end subroutine judge

  !> Make a check.
  subroutine make_check(path, a, check)
    type(checked_path_type), intent(in) :: path   !! the path
    real(wp), intent(in) :: a(:, 0:)              !! results along it
    type(check_type), intent(inout) :: check      !! with its name -> complete
    real(wp), allocatable :: b(:, :), c(:, :)
    real(wp) :: sums(0:size(path%dt)), work(0:size(path%dt))
    character(len=:), allocatable :: failure, name
    type(walk_type) :: plan
    integer :: i, m, n
    m = size(a, 1)
    n = size(path%dt)
    plan%path = path
    failure = ""
    check%text = ""
    select case (check%name)
    case ("arguments")
      plan%how = call_type(strict=.true.)
      call walk(plan, b, failure)
      plan%how%ones = .true.
      call compare(b, "with other numbers behind the arguments", "nothing is written or read outside its own")
    case ("repeated")
      plan%kind = trying
      call compare(a, "when a call is repeated", "the same when a call is repeated")
    case ("cut")
      plan%parts = 2
      call walk(plan, b, failure)
      plan%kind = trying
      call compare(b, "after a larger increment", "the same after a larger increment that is tried first")
    case ("alternating", "threads")
      plan%factors = other
      call walk(plan, b, failure)
      plan%known = reshape([a, b], [m, n + 1, 2])
      plan%kind = merge(with_other, in_threads, check%name == "alternating")
      if (plan%kind == with_other) then
        call compare(reshape([(a(:, i), b(:, i), i=0, n)], [2*m, n + 1]), "beside another point", &
          "two points in turn do not disturb each other")
      else
        call compare(reshape([(0.0_wp, i=0, 2*n + 1)], [2, n + 1]), "from two threads", "the same from two threads")
      end if
    case ("absent")
      do i = 0, huge(i) - 1
        name = absent_name(i)
        if (len(name) == 0 .or. check%outcome == failed) exit
        plan%how = call_type(absent=i)
        call compare(a, "if " // name // " is NULL", "arguments that hosts may not have can be NULL")
        if (failure /= "") call judge(check, failed, "it uses " // name // ", which hosts may not have: " // failure)
      end do
    case ("components")
      call check_components()
    case ("tangent")
      plan%kind = with_differences
      plan%known = reshape(a, [m, n + 1, 1])
      call walk(plan, b, failure)
      call check_tangent(path, a, b, check)
    case ("symmetry")
      do i = 1, n
        check%measured = max(check%measured, maxval(abs(a([5, 6, 9], i) - a([7, 10, 11], i)))/path%law%stiffness)
      end do
      call judge(check, stated, "DDSDDE is symmetric")
      if (check%measured > rounding) check%text = "DDSDDE is not symmetric, by up to " // short(check%measured) // &
        " of the stiffness: use the unsymmetric solver"
    case ("energies")
      plan%parts = energy_parts
      if (path%law%umat%has_energies) call walk(plan, b, failure)
      if (path%law%umat%has_energies) call check_energies()
    case ("dissipation")
      sums = sum(a(n_first + [v_rupture, v_friction], :), 1)
      work(1:) = sums(1:) - sums(:n - 1)
      i = minloc(work(1:), 1)
      check%limit = rounding*maxval(abs(sums))
      check%measured = max(0.0_wp, -work(i))
      call judge(check, passed, "SPD + SCD never decrease")
      if (check%measured > check%limit) call judge(check, failed, place(path, i) // "SPD + SCD decrease by " // &
        short(check%measured))
      if (.not. any(abs(sums) > 0.0_wp)) call judge(check, not_judged, "SPD and SCD are zero")
    case default
      call judge(check, not_judged, "no such check")
    end select
    if (any(check%name == ["energies   ", "dissipation"]) .and. .not. path%law%umat%has_energies) then
      call judge(check, not_declared, "energies = .false.")
    else if (failure /= "" .and. index(check%text, failure) == 0) then
      call judge(check, failed, failure)
    end if

  contains

    !> Walk, and compare the results with others, to which they must be equal to the last bit.
    subroutine compare(expected, doubt, praise)
      real(wp), intent(in) :: expected(:, 0:)        !! results
      character(len=*), intent(in) :: doubt, praise  !! when they differ, and if they are equal
      integer :: j
      if (failure == "") call walk(plan, c, failure)
      if (failure /= "") return
      call judge(check, passed, praise)
      do j = n, 1, -1
        if (any(abs(c(:, j) - expected(:, j)) > 0.0_wp)) call judge(check, failed, "other results " // doubt // &
          ", first " // place(path, j))
      end do
    end subroutine compare

    !> Work of the traction and energies along the path in small parts.
    subroutine check_energies()
      integer :: j
      sums = sum(b(n_first + [v_stored, v_rupture, v_friction], :), 1)
      sums = sums - sums(0)
      work = b(n_first + u_work, :) - b(n_first + u_work, 0)
      j = maxloc(abs(work - sums), 1) - 1
      check%measured = abs(work(j) - sums(j))/max(maxval(abs(work)), tiny(work))
      check%limit = energy_error
      call judge(check, passed, "work = SSE + SPD + SCD within " // short(check%measured) // " of the largest work")
      if (check%measured > check%limit) call judge(check, failed, place(path, j) // "the work is " // &
        short(work(j)) // ", SSE + SPD + SCD " // short(sums(j)))
      if (.not. any(abs(sums) > 0.0_wp)) call judge(check, failed, "SSE, SPD and SCD are zero: the host knows no " // &
        "energies of this law; expected energies = .false. if it has none")
    end subroutine check_energies

    !> The same results with 2, 3 and 6 components; without Ty for 2.
    subroutine check_components()
      integer, parameter :: ntens(3) = [3, 2, 6], places(3, 3) = reshape([1, 2, 3, 1, 2, 0, 3, 5, 6], [3, 3])
      integer, parameter :: of_two(6) = [1, 2, 4, 5, 7, 8], of_all(12) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
      real(wp) :: unit(12)
      integer :: first, j
      unit = [spread(path%law%stress, 1, 3), spread(path%law%stiffness, 1, 9)]
      check%limit = component_error
      if (count([(any(path%law%umat%declared == ntens(j)), j=1, 3)]) < 2) then
        call judge(check, not_declared, "one NTENS only")
        return
      end if
      j = findloc(ntens, path%law%umat%ntens, dim=1)
      if (any(path%law%umat%position /= places(:, j))) then
        call judge(check, not_judged, "expected order = 'N,Tx', 'N,Tx,Ty' or '-,-,N,-,Tx,Ty'")
        return
      end if
      plan%factors = [1.0_wp, 1.0_wp, 0.0_wp]
      first = 0
      do j = 1, 3
        if (all(path%law%umat%declared /= ntens(j))) cycle
        associate (law => plan%path%law)
          law%umat%ntens = ntens(j)
          law%umat%position = places(:, j)
          law%n_state = n_header + law%umat%ntens + law%umat%nstatv
          plan%path%start = law%virgin()
        end associate
        call walk(plan, b, failure)
        if (failure /= "") then
          call judge(check, failed, "with NTENS = " // integer_text(ntens(j)) // " " // failure // &
            "; expected ntens = " // integer_text(path%law%umat%ntens) // " if it has these components only")
          return
        end if
        if (first == 0) then
          first = ntens(j)
          c = b(:n_first, :)
          cycle
        end if
        associate (k => pack(of_all, [(ntens(j) /= 2 .and. first /= 2 .or. any(of_two == i), i=1, 12)]))
          check%measured = max(check%measured, maxval(abs(c(k, :) - b(k, :))/spread(unit(k), 2, n + 1)))
        end associate
        if (check%measured > check%limit) then
          call judge(check, failed, "NTENS = " // integer_text(ntens(j)) // " differs from " // integer_text(first) // &
            " by " // short(check%measured) // " of strength or stiffness (33, 13, 23 of 6)")
          return
        end if
      end do
      call judge(check, passed, "the same with each NTENS")
    end subroutine check_components

  end subroutine make_check

  !> Step and increment of the case.
  pure function place(path, j) result(text)
    type(checked_path_type), intent(in) :: path   !! the path
    integer, intent(in) :: j                      !! increment of it
    character(len=:), allocatable :: text
    text = "in step " // integer_text(path%step(max(1, j))) // " increment " // &
      integer_text(path%increment(max(1, j))) // " "
  end function place

  !> DDSDDE beside central differences. Where those from both sides differ, there is a kink, which is named.
  subroutine check_tangent(path, a, differences, check)
    type(checked_path_type), intent(in) :: path   !! the path
    real(wp), intent(in) :: a(:, 0:)              !! results along it
    real(wp), intent(in) :: differences(:, 0:)    !! traction, and whether STATEV changes, beside them
    type(check_type), intent(inout) :: check      !! the check
    real(wp) :: beside(4, 2, 2, 3), error(3), errors(3), h, unit
    character(len=:), allocatable :: text
    integer :: contacts, i, j, k, kinks, loadings, wrong
    logical :: kinked
    contacts = 0
    loadings = 0
    kinks = 0
    wrong = 0
    check%limit = tangent_error
    text = "that of central differences"
    do i = 1, size(path%dt)
      unit = max(path%law%stiffness, maxval(abs(a(4:12, i))))
      beside = reshape(differences(:, i), shape(beside))
      do j = 1, 3
        if (path%law%umat%position(j) == 0) cycle
        do k = 1, 2
          h = difference(k)*path%law%length
          associate (higher => beside(:3, 1, k, j), lower => beside(:3, 2, k, j))
            errors = abs((higher - lower)/(2.0_wp*h) - a(3*j + 1:3*j + 3, i))/unit
            ! where both sides are alike, kinks and jumps on both cancel: a shorter step is beside the kinks, and the
            ! error of a jump grows with it
            kinked = maxval(abs(higher - 2.0_wp*a(:3, i) + lower)) > h*unit*min(kink, maxval(errors))
          end associate
          if (k == 2) kinked = kinked .or. maxval(errors) > 0.5_wp*difference(1)/difference(2)*maxval(error)
          if (k == 1 .or. maxval(errors) <= tangent_error) error = errors
          if (kinked .or. maxval(error) <= tangent_error) exit
        end do
        if (maxval(error) > tangent_error .and. kinked) then
          kinks = kinks + 1
          if (abs(path%s(1, i + 1)) <= h) then
            contacts = contacts + 1
          else if (abs(beside(4, 1, k, j) - beside(4, 2, k, j)) > 0.0_wp) then
            loadings = loadings + 1
          end if
          cycle
        end if
        if (maxval(error) > max(tangent_error, check%measured)) text = place(path, i) // "d t_" // &
          trim(component_names(maxloc(error, 1))) // "/d s_" // trim(component_names(j)) // &
          " differs from differences by " // short(maxval(error)) // " of the stiffness"
        check%measured = max(check%measured, maxval(error))
        if (maxval(error) > tangent_error) wrong = wrong + 1
      end do
    end do
    if (wrong > 0) text = text // "; columns that differ: " // integer_text(wrong)
    if (kinks > 0) text = text // "; not differenced: " // integer_text(kinks) // " columns at kinks (" // &
      integer_text(loadings) // " between loading and unloading, " // integer_text(contacts) // &
      " at s_N = 0, " // integer_text(kinks - loadings - contacts) // " others)"
    call judge(check, passed, text)
    if (wrong > 0 .or. kinks >= size(path%dt)*count(path%law%umat%position > 0)) check%outcome = failed
  end subroutine check_tangent

  !> Walk along a path in a child.
  subroutine walk(plan, found, failure)
    type(walk_type), intent(in), target :: plan                 !! how
    real(wp), allocatable, intent(out) :: found(:, :)           !! (:, 0:n) results after each increment
    character(len=:), allocatable, intent(out) :: failure       !! why the UMAT has failed, empty: it has not
    type(worker_type) :: worker
    integer :: i, n
    n = n_first + plan%path%law%n_state
    if (plan%kind == with_other) n = 2*n
    if (plan%kind == in_threads) n = 2
    if (plan%kind == with_differences) n = n_differences
    allocate (found(n, 0:size(plan%path%dt)), source=0.0_wp)
    if (any(plan%kind == [alone, trying])) found(n_first + 1:, 0) = plan%path%start
    call start_worker(c_funloc(walk_there), c_loc(plan), plan%path%law%umat%limit)
    i = 0
    do while (receive_row(found(:, min(i + 1, size(plan%path%dt))), n) /= 0)
      i = i + 1
    end do
    call end_worker(worker)
    failure = worker%failure
  end subroutine walk

  !> The work of the child.
  subroutine walk_there(data) bind(c, name="asperity_umat_walk_there")
    type(c_ptr), value :: data   !! walk
    type(walk_type), pointer :: plan
    type(foreign_law) :: law
    real(wp), allocatable :: a(:), b(:)
    integer :: i, k
    call c_f_pointer(data, plan)
    law = plan%path%law
    call open_umat(law, plan%how)
    allocate (a(n_first + law%n_state), source=0.0_wp)
    a(n_first + 1:) = plan%path%start
    b = a
    if (plan%kind == in_threads) call c_threads(c_funloc(walk_often), data)
    do i = 1, size(plan%path%dt)
      select case (plan%kind)
      case (with_other)
        a = after(law, plan%path, i, same, [0.0_wp, 1.0_wp], a(n_first + 1:))
        b = after(law, plan%path, i, other, [0.0_wp, 1.0_wp], b(n_first + 1:))
        call send_row([a, b], 2*size(a))
      case (in_threads)
        call send_row(merge(1.0_wp, 0.0_wp, i >= plan%differs), 2)
      case (with_differences)
        call send_row(differences_at(law, plan, i), n_differences)
      case default
        if (plan%kind == trying) b = after(law, plan%path, i, same, [0.0_wp, 1.0_wp], a(n_first + 1:))
        do k = 1, plan%parts
          a = after(law, plan%path, i, plan%factors, real([k - 1, k], wp)/real(plan%parts, wp), a(n_first + 1:))
        end do
        call send_row(a, size(a))
      end select
    end do
  end subroutine walk_there

  !> Traction, and whether STATEV changes, with each component at the end of an increment larger and smaller, by two
  !> steps.
  function differences_at(law, plan, i) result(found)
    type(foreign_law), intent(inout) :: law   !! its attempts are counted
    type(walk_type), intent(in) :: plan       !! the walk
    integer, intent(in) :: i                  !! increment
    real(wp) :: beside(4, 2, 2, 3), found(n_differences), move(3), there(n_first + law%n_state)
    integer :: j, k, side, statev
    statev = n_header + law%umat%ntens
    beside = 0.0_wp
    do j = 1, 3
      if (law%umat%position(j) == 0) cycle
      do k = 1, 2
        do side = 1, 2
          move = 0.0_wp
          move(j) = merge(1.0_wp, -1.0_wp, side == 1)*difference(k)*law%length
          associate (old => plan%known(n_first + 1:, i, 1))
            there = after(law, plan%path, i, same, [0.0_wp, 1.0_wp], old, move)
            beside(:3, side, k, j) = there(:3)
            if (any(abs(there(n_first + statev + 1:) - old(statev + 1:)) > 0.0_wp)) beside(4, side, k, j) = 1.0_wp
          end associate
        end do
      end do
    end do
    found = reshape(beside, shape(found))
  end function differences_at

  !> Results after a part of an increment.
  function after(law, path, i, factors, part, old, move) result(found)
    type(foreign_law), intent(inout) :: law               !! its attempts are counted
    type(checked_path_type), intent(in) :: path           !! the path
    integer, intent(in) :: i                              !! increment
    real(wp), intent(in) :: factors(3)                    !! of the components of the path
    real(wp), intent(in) :: part(2)                       !! start and end, 0 to 1
    real(wp), intent(in) :: old(:)                        !! state at the start
    real(wp), intent(in), optional :: move(3)             !! added to the separation at the end
    real(wp) :: found(n_first + size(old))
    real(wp) :: d(3, 3), s(3, 2), state(size(old))
    integer :: k
    do k = 1, 2
      s(:, k) = factors*(path%s(:, i) + part(k)*(path%s(:, i + 1) - path%s(:, i)))
      if (part(k) >= 1.0_wp) s(:, k) = factors*path%s(:, i + 1)
    end do
    if (present(move)) s(:, 2) = s(:, 2) + move
    law%step = path%step(i)
    law%increment = path%increment(i)
    law%attempt = law%attempt + 1
    call law%update(s(:, 1), s(:, 2), old, state, found(:3), d, (part(2) - part(1))*path%dt(i), 0.0_wp)
    found(4:n_first) = reshape(d, [9])
    found(n_first + 1:) = state
  end function after

  !> Go along the path of a thread many times, and compare.
  subroutine walk_often(which, data) bind(c, name="asperity_umat_walk_often")
    integer(c_int), value :: which   !! thread, 1 or 2
    type(c_ptr), value :: data       !! walk
    type(walk_type), pointer :: plan
    type(foreign_law) :: law
    real(wp), allocatable :: found(:)
    integer :: i, k
    call c_f_pointer(data, plan)
    law = plan%path%law
    do i = 1, 1 + thread_updates/size(plan%path%dt)
      found = [spread(0.0_wp, 1, n_first), plan%path%start]
      do k = 1, size(plan%path%dt)
        found = after(law, plan%path, k, merge(same, other, which == 1), [0.0_wp, 1.0_wp], found(n_first + 1:))
        if (any(abs(found - plan%known(:, k + 1, which)) > 0.0_wp)) plan%differs(which) = min(plan%differs(which), k)
      end do
    end do
  end subroutine walk_often

end module asperity_umat_checks
