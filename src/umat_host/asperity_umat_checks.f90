!> Checks of a UMAT along a load path, as a table: what the walks of asperity_umat_walk send is judged here.
module asperity_umat_checks
  use asperity_contract, only: v_friction, v_rupture, v_stored
  use asperity_foreign_umat, only: foreign_law, how_type, n_header, u_work
  use asperity_kinds, only: wp
  use asperity_steps, only: component_names
  use asperity_text, only: integer_text, short
  use asperity_umat_stiffness, only: try_stiffness
  use asperity_umat_walk, only: checked_path_type, difference, n_first, walk, walk_type
  implicit none
  private
  public :: check_umat

  !> Outcomes of a check.
  character(len=*), parameter, public :: passed = "passed", failed = "FAILED", stated = "stated", &
    not_judged = "not judged", not_declared = "not declared"

  !> Checks in their order; those from `first_compared` on compare walks, and from `first_judged` on they are of no
  !> meaning if a UMAT has hidden state, which the comparisons from `first_hidden` on find.
  character(len=*), parameter, public :: check_names(15) = [character(len=12) :: "stiffness", "written", "arguments", &
    "unmoved", "repeated", "cut", "alternating", "threads", "restart", "absent", "components", "tangent", "symmetry", &
    "energies", "dissipation"]
  character(len=*), parameter :: of_energies(2) = [character(len=12) :: "energies", "dissipation"]
  integer, parameter :: first_compared = 2, first_hidden = 5, first_judged = 10

  !> A check that compares the results of two walks to the last bit: how the second is made, and the first with the same
  !> parts and strictness.
  type :: comparison_type
    character(len=48) :: when                 !! results are the same, or others
    type(how_type) :: how                     !! the second walk
    logical :: two = .false.                  !! whether the second has two points, which the first has one by one
  end type comparison_type
  !> The first checks.
  type(comparison_type), parameter :: comparisons(first_compared:first_judged) = [ &
    comparison_type("with other numbers in DDSDDE at entry", how_type(marks=.true.)), &
    comparison_type("with other numbers outside its arguments", how_type(strict=.true., ones=.true.)), &
    comparison_type("without a change of the separation, in no time", how_type(rests=.true.)), &
    comparison_type("when a call is repeated", how_type(tries=.true.)), &
    comparison_type("after a larger increment that is tried first", how_type(tries=.true., parts=2)), &
    comparison_type("beside another point", how_type(), two=.true.), &
    comparison_type("from two threads", how_type(threads=.true.), two=.true.), &
    comparison_type("in a new process and step after an unloading", how_type(late=.true.)), &
    comparison_type("where arguments that hosts may not have are NULL", how_type())]

  !> Arguments that hosts without temperatures, elements or orientations pass as NULL.
  character(len=*), parameter :: may_be_absent(18) = [character(len=6) :: "RPL", "DDSDDT", "DRPLDE", "DRPLDT", &
    "TEMP", "DTEMP", "PREDEF", "DPRED", "COORDS", "DROT", "PNEWDT", "CELENT", "DFGRD0", "DFGRD1", "NOEL", "NPT", &
    "LAYER", "KSPT"]

  !> Largest error of DDSDDE and, at a kink, of a one-sided difference, relative to the stiffness; largest error of the
  !> energies, relative to the largest work, with each increment in parts; what is a rounding error, and what is one of
  !> a result with another number of components.
  real(wp), parameter :: tangent_error = 1.0e-5_wp, kink = 1.0e-3_wp, energy_error = 0.01_wp, rounding = 1.0e-9_wp, &
    component_error = 1.0e-12_wp
  integer, parameter :: energy_parts = 16
  !> Numbers that a remark names.
  integer, parameter :: most_unchanged = 4
  !> Factors of the components of the path for the first point and for the second one.
  real(wp), parameter :: factors_of(3, 2) = reshape([1.0_wp, 1.0_wp, 1.0_wp, 0.6_wp, -0.6_wp, 0.3_wp], [3, 2])

  !> A row of the table.
  type, public :: check_type
    character(len=12) :: name = ""           !! of the check
    character(len=12) :: outcome = passed
    character(len=:), allocatable :: text    !! what was found
  end type check_type

contains

  !> Make the checks of a UMAT.
  subroutine check_umat(path, checks)
    type(checked_path_type), intent(in) :: path            !! the path
    type(check_type), intent(out) :: checks(:)             !! in the order of check_names
    type(walk_type) :: plan
    real(wp), allocatable :: a(:, :)
    character(len=:), allocatable :: failure, text
    logical :: good, hidden
    integer :: i
    hidden = .false.
    plan%path = path
    plan%factors = factors_of(:, :1)
    call walk(plan, a, failure)
    do i = 1, size(check_names)
      checks(i)%name = check_names(i)
      if (i < first_compared .and. is_damaged(path%law)) then
        call judge(checks(i), not_judged, "the path begins with damage")
      else if (i < first_compared) then
        call try_stiffness(path, good, text)
        call judge(checks(i), trim(merge(passed, failed, good)), text)
      else if (size(path%dt) == 0) then
        call judge(checks(i), not_judged, "the path has no increment")
      else if (hidden .and. i >= first_judged) then
        call judge(checks(i), not_judged, "results depend on earlier calls")
      else if (len(failure) > 0 .and. i >= first_hidden) then
        call judge(checks(i), not_judged, failure)
      else if (i < first_judged) then
        call compare(comparisons(max(first_compared, min(i, first_judged))), plan, a, checks(i))
        if (i == first_compared .and. checks(i)%outcome == passed) call judge(checks(i), passed, "all of DDSDDE" // &
          unchanged(plan, a))
      else
        call make_check(plan, a, checks(i))
      end if
      hidden = hidden .or. (checks(i)%outcome == failed .and. i >= first_hidden .and. i < first_judged)
    end do
  end subroutine check_umat

  !> Whether the state that &umat gives has damage.
  pure logical function is_damaged(law)
    type(foreign_law), intent(in) :: law   !! the law
    is_damaged = .false.
    if (law%umat%damage > 0) is_damaged = law%umat%first(law%umat%damage) > 0.0_wp
  end function is_damaged

  !> Numbers of STRESS and STATEV that the walk of a host leaves as they are, as a remark.
  function unchanged(plan, a) result(text)
    type(walk_type), intent(in) :: plan   !! the walk
    real(wp), intent(in) :: a(:, 0:)      !! its results
    character(len=:), allocatable :: text
    integer :: i, left
    text = ""
    left = 0
    do i = 1, plan%path%law%umat%ntens + plan%path%law%umat%nstatv
      if (any(abs(a(n_first + n_header + i, 1:) - a(n_first + n_header + i, 0)) > 0.0_wp)) cycle
      left = left + 1
      if (left > most_unchanged) cycle
      associate (statev => i - plan%path%law%umat%ntens)
        if (statev > 0) text = text // ", STATEV(" // integer_text(statev) // ")"
        if (statev <= 0) text = text // ", STRESS(" // integer_text(i) // ")"
      end associate
    end do
    if (left > most_unchanged) text = text // " and " // integer_text(left - most_unchanged) // " more"
    if (left > 0) text = "; along the path it never changes " // text(3:)
  end function unchanged

  !> Set outcome and text of a check.
  subroutine judge(check, outcome, text)
    type(check_type), intent(inout) :: check   !! the check
    character(len=*), intent(in) :: outcome    !! one of the five
    character(len=*), intent(in) :: text       !! what was found
    check%outcome = outcome
    check%text = text
  end subroutine judge

  !> Make a check that compares two walks.
  subroutine compare(comparison, usual, a, check)
    type(comparison_type), intent(in) :: comparison   !! the check
    type(walk_type), intent(in) :: usual              !! the walk of a host
    real(wp), intent(in) :: a(:, 0:)                  !! its results
    type(check_type), intent(inout) :: check          !! -> complete
    type(walk_type) :: plan
    real(wp), allocatable :: b(:, :), differ(:, :)
    character(len=:), allocatable :: failure
    integer :: j
    plan = usual
    plan%how = how_type(strict=comparison%how%strict, parts=comparison%how%parts)
    if (comparison%two) plan%factors = factors_of(:, 2:)
    failure = ""
    b = a
    if (comparison%how%strict .or. comparison%two .or. comparison%how%parts > 1) call walk(plan, b, failure)
    if (len(failure) == 0) then
      plan%known = reshape(b, [shape(b), 1])
      if (comparison%two) plan%known = reshape([a, b], [shape(b), 2])
      if (comparison%two) plan%factors = factors_of
      plan%how = comparison%how
      call walk(plan, differ, failure)
      j = findloc(differ(1, 1:) > 0.0_wp, .true., dim=1)
      call judge(check, passed, "the same " // trim(comparison%when))
      if (j > 0) call judge(check, failed, "other results " // trim(comparison%when) // ", first " // &
        place(plan%path, j))
    end if
    if (len(failure) > 0) call judge(check, failed, failure)
  end subroutine compare

  !> Make another check.
  subroutine make_check(usual, a, check)
    type(walk_type), intent(in) :: usual          !! the walk of a host
    real(wp), intent(in) :: a(:, 0:)              !! its results
    type(check_type), intent(inout) :: check      !! with its name -> complete
    real(wp), allocatable :: b(:, :)
    character(len=:), allocatable :: failure
    type(comparison_type) :: comparison
    type(walk_type) :: plan
    real(wp) :: error, sums(0:size(a, 2) - 1), work(0:size(a, 2) - 1)
    integer :: i, n
    n = size(a, 2) - 1
    plan = usual
    failure = ""
    select case (check%name)
    case ("absent")
      comparison = comparisons(first_judged)
      do i = 1, size(may_be_absent)
        comparison%how%absent = may_be_absent(i)
        call compare(comparison, plan, a, check)
        if (check%outcome /= failed) cycle
        call judge(check, failed, "it uses " // trim(may_be_absent(i)) // ", which hosts may not have: " // check%text)
        exit
      end do
    case ("components")
      call check_components(plan, check)
    case ("tangent")
      plan%differences = .true.
      plan%known = reshape(a, [shape(a), 1])
      call walk(plan, b, failure)
      call check_tangent(plan%path, a, b, check)
    case ("symmetry")
      error = maxval(abs(a([5, 6, 9], 1:) - a([7, 10, 11], 1:)))/plan%path%law%stiffness
      call judge(check, stated, "DDSDDE is symmetric")
      if (error > rounding) call judge(check, stated, "DDSDDE is not symmetric, by up to " // short(error) // &
        " of the stiffness: use the unsymmetric solver")
    case ("energies")
      plan%how%parts = energy_parts
      b = a
      if (plan%path%law%umat%has_energies) call walk(plan, b, failure)
      sums = sum(b(n_first + [v_stored, v_rupture, v_friction], :), 1)
      sums = sums - sums(0)
      work = b(n_first + u_work, :) - b(n_first + u_work, 0)
      i = maxloc(abs(work - sums), 1) - 1
      error = abs(work(i) - sums(i))/max(maxval(abs(work)), tiny(work))
      call judge(check, passed, "work = SSE + SPD + SCD within " // short(error) // " of the largest work")
      if (error > energy_error) call judge(check, failed, place(plan%path, i) // "the work is " // short(work(i)) // &
        ", SSE + SPD + SCD " // short(sums(i)))
      if (.not. any(abs(sums) > 0.0_wp)) call judge(check, failed, "SSE, SPD and SCD are zero: the host knows no " // &
        "energies of this law; expected energies = .false. if it has none")
    case default
      sums = sum(a(n_first + [v_rupture, v_friction], :), 1)
      i = minloc(sums(1:) - sums(:n - 1), 1)
      error = sums(i - 1) - sums(i)
      call judge(check, passed, "SPD + SCD never decrease")
      if (error > rounding*maxval(abs(sums))) call judge(check, failed, place(plan%path, i) // &
        "SPD + SCD decrease by " // short(error))
      if (.not. any(abs(sums) > 0.0_wp)) call judge(check, not_judged, "SPD and SCD are zero")
    end select
    if (len(failure) > 0) call judge(check, failed, failure)
    if (any(check%name == of_energies) .and. .not. plan%path%law%umat%has_energies) call judge(check, &
      not_declared, "energies = .false.")
  end subroutine make_check

  !> The same results with 2, 3 and 6 components; without Ty for 2.
  subroutine check_components(usual, check)
    type(walk_type), intent(in) :: usual          !! the walk of a host
    type(check_type), intent(inout) :: check      !! the check
    integer, parameter :: ntens(3) = [3, 2, 6], places(3, 3) = reshape([1, 2, 3, 1, 2, 0, 3, 5, 6], [3, 3])
    integer, parameter :: of_ty(6) = [3, 6, 9, 10, 11, 12]
    type(walk_type) :: plan
    real(wp), allocatable :: b(:, :), c(:, :)
    character(len=:), allocatable :: failure
    real(wp) :: error
    integer :: first, i, j
    plan = usual
    associate (umat => usual%path%law%umat)
      if (count([(any(umat%declared == ntens(i)), i=1, 3)]) < 2) then
        call judge(check, not_declared, "one NTENS only")
        return
      else if (any(umat%position /= places(:, findloc(ntens, umat%ntens, dim=1)))) then
        call judge(check, not_judged, "expected order = 'N,Tx', 'N,Tx,Ty' or '-,-,N,-,Tx,Ty'")
        return
      end if
    end associate
    plan%factors = reshape([1.0_wp, 1.0_wp, 0.0_wp], [3, 1])
    first = 0
    allocate (c(n_first, 0:size(plan%path%dt)))
    do j = 1, 3
      if (all(usual%path%law%umat%declared /= ntens(j))) cycle
      associate (law => plan%path%law)
        law%umat%ntens = ntens(j)
        law%umat%position = places(:, j)
        law%n_state = n_header + law%umat%ntens + law%umat%nstatv
        plan%path%start = law%virgin()
        call walk(plan, b, failure)
        if (len(failure) > 0) then
          call judge(check, failed, "with NTENS = " // integer_text(ntens(j)) // " " // failure // &
            "; expected ntens = " // integer_text(usual%path%law%umat%ntens) // " if it has these components only")
          return
        end if
        if (first == 0) c(:, :) = b(:n_first, :)
        if (first == 0) first = ntens(j)
        if (any([first, ntens(j)] == 2)) b(of_ty, :) = c(of_ty, :)
        b(:n_first, :) = abs(b(:n_first, :) - c)
        error = max(maxval(b(:3, :))/law%stress, maxval(b(4:n_first, :))/law%stiffness)
      end associate
      if (error > component_error) then
        call judge(check, failed, "NTENS = " // integer_text(ntens(j)) // " differs from " // integer_text(first) // &
          " by " // short(error) // " of strength or stiffness (33, 13, 23 of 6)")
        return
      end if
    end do
    call judge(check, passed, "the same with each NTENS")
  end subroutine check_components

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
    real(wp) :: beside(4, 2, 2, 3), error(3), errors(3), h, unit, worst
    character(len=:), allocatable :: text
    integer :: contacts, i, j, k, kinks, loadings, wrong
    logical :: kinked
    contacts = 0
    loadings = 0
    kinks = 0
    wrong = 0
    worst = 0.0_wp
    text = "that of central differences"
    do i = 1, size(path%dt)
      unit = max(path%law%stiffness, maxval(abs(a(4:12, i))))
      beside = reshape(differences(:, i), shape(beside))
      do j = 1, 3
        if (path%law%umat%position(j) == 0) cycle
        do k = 1, 2
          h = difference(k)*path%law%s_0
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
        if (maxval(error) > max(tangent_error, worst)) text = place(path, i) // "d t_" // &
          trim(component_names(maxloc(error, 1))) // "/d s_" // trim(component_names(j)) // &
          " differs from differences by " // short(maxval(error)) // " of the stiffness"
        worst = max(worst, maxval(error))
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

end module asperity_umat_checks
