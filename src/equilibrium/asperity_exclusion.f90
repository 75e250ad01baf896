!> Proof that no separation carries prescribed tractions: branch and bound over all separations.
!>
!> Over a box of separations the traction is enclosed by linear functions of the place with an error. The values that
!> it may have there are then inside a polyhedron. If the prescribed tractions are outside, the box has no equilibrium;
!> otherwise the polyhedron tells which part of the box may have one, and what is left of the box is halved. If no box
!> is left, no equilibrium exists, up to the largest separation that a load path may have.
module asperity_exclusion
  use asperity_bounded_equations, only: bound_solutions, equations_type
  use asperity_bounds, only: away_from_contact
  use asperity_control_point, only: balance_type, control_type, point_type, prescribed_bound, set_balance
  use asperity_enclosure, only: coordinate, enclosure_type, multiple, size_of, sum_of
  use asperity_interface, only: interface_type
  use asperity_kinds, only: wp
  use asperity_traction_bounds, only: enclose_traction, rounding_of_law, timed_constants, timed_type
  implicit none
  private
  public :: exclude_equilibria

  !> Number of boxes that take half a second with 65 planes, and less with fewer.
  integer, parameter, public :: most_boxes = 20000

  !> Bounds of a separation.
  type :: range_type
    real(wp) :: low, high
  end type range_type

  !> What does not differ from box to box.
  type :: question_type
    type(balance_type) :: balance       !! the equations
    type(timed_type) :: material     !! constants of the law over the increment
    real(wp) :: outward(3) = 0.0_wp     !! direction in which no contact carries a traction
  end type question_type

contains

  !> Prove that no separation carries given values in one increment from the state of a point on.
  !>
  !> With the guard, and on facets, nothing is proved: the guard depends on the path, and the traction of a facet has no
  !> such simple bounds.
  pure subroutine exclude_equilibria(joint, control, given, point, most, proven, boxes)
    type(interface_type), intent(in) :: joint      !! the interface
    type(control_type), intent(in) :: control      !! what is given, at least one traction
    real(wp), intent(in) :: given(3)               !! its values
    type(point_type), intent(in) :: point          !! the last point found
    integer, intent(in) :: most                    !! largest number of boxes
    logical, intent(out) :: proven                 !! whether no equilibrium exists
    integer, intent(out) :: boxes                  !! boxes that were examined
    !> A box has at most 3 x 200 halves of a finite length.
    integer, parameter :: deepest = 700
    !> A box that has become shorter than this fraction is examined again before it is halved.
    real(wp), parameter :: much_shorter = 0.7_wp
    type(question_type) :: question
    type(range_type) :: box(3), pending(3, deepest), whole(3)
    logical :: divided, outside
    integer :: i, left

    proven = .false.
    boxes = 0
    if (joint%material%guard .or. joint%material%curved) return
    call set_balance(joint, control, given, question%balance)
    if (question%balance%n == 0) return
    question%material = timed_constants(joint%material, control%dt)
    question%outward = away_from_contact(joint, control, given)
    do i = 1, 3
      pending(i, 1) = range_type(given(i), given(i))
      if (control%traction(i)) pending(i, 1) = range_type(-prescribed_bound(joint), prescribed_bound(joint))
    end do
    left = 1
    do while (left > 0 .and. boxes < most .and. left < deepest)
      whole = pending(:, left)
      left = left - 1
      boxes = boxes + 1
      box = whole
      call examine_box(joint, question, point%state, box, outside)
      if (outside) cycle
      if (any(box%high - box%low < much_shorter*(whole%high - whole%low))) then
        left = left + 1
        pending(:, left) = box
      else
        call halve_box(joint, question%balance, box, pending(:, left + 1), pending(:, left + 2), divided)
        if (.not. divided) return
        left = left + 2
      end if
    end do
    proven = left == 0
  end subroutine exclude_equilibria

  !> Divide a box across its longest side. Sides that reach over several orders of magnitude are divided at zero or at
  !> the geometric mean of their ends.
  pure subroutine halve_box(joint, balance, box, first, last, divided)
    type(interface_type), intent(in) :: joint              !! the interface
    type(balance_type), intent(in) :: balance              !! free components
    type(range_type), intent(in) :: box(3)                 !! the box
    type(range_type), intent(out) :: first(3), last(3)     !! its halves
    logical, intent(out) :: divided                        !! false: its sides are too short to be divided
    real(wp), parameter :: orders = 16.0_wp
    real(wp) :: least, middle, near, far
    integer :: i
    first = box
    last = box
    i = balance%free(maxloc(box(balance%free(:balance%n))%high - box(balance%free(:balance%n))%low, 1))
    least = epsilon(1.0_wp)*joint%material%s0
    near = max(joint%material%s0, min(abs(box(i)%low), abs(box(i)%high)))
    far = max(-box(i)%low, box(i)%high)
    middle = box(i)%low + 0.5_wp*(box(i)%high - box(i)%low)
    if (far > orders*near) then
      middle = sign(sqrt(far)*sqrt(near), middle)
      if (box(i)%low < 0.0_wp .and. box(i)%high > 0.0_wp) middle = 0.0_wp
    end if
    divided = box(i)%high - box(i)%low > max(least, 4.0_wp*spacing(far))
    first(i)%high = middle
    last(i)%low = middle
  end subroutine halve_box

  !> Find out whether a box has no equilibrium, and shorten it to the part that may have one.
  pure subroutine examine_box(joint, question, state, box, outside)
    type(interface_type), intent(in) :: joint       !! the interface
    type(question_type), intent(in) :: question     !! what is asked
    real(wp), intent(in) :: state(:)                !! STATEV at the start of the increment
    type(range_type), intent(inout) :: box(3)       !! separations
    logical, intent(out) :: outside                 !! whether it has no equilibrium
    type(enclosure_type) :: force, s(3), traction(3)
    type(equations_type) :: equations
    real(wp) :: error, most
    integer :: i, j, k
    do i = 1, 3
      s(i) = coordinate(i, box(i)%low, box(i)%high)
    end do
    call enclose_traction(joint, question%material, state, s, question%outward, traction, most)
    associate (balance => question%balance)
      outside = most + rounding_of_law*sum(abs(balance%given)) < dot_product(question%outward, balance%given)
      equations%n = balance%n
      do i = 1, balance%n
        k = balance%free(i)
        force = sum_of(traction(k), multiple(balance%control%spring(k), s(k)))
        error = rounding_of_law*size_of(force)
        outside = outside .or. force%low - error > balance%given(k) .or. force%high + error < balance%given(k)
        equations%centre(i) = force%centre - balance%given(k)
        do j = 1, balance%n
          equations%generators(i, j) = force%slope(balance%free(j))
        end do
        equations%generators(i, balance%n + i) = force%error + error
      end do
      if (outside) return
      call bound_solutions(equations)
      outside = .not. equations%solvable
      if (outside) return
      do i = 1, balance%n
        call shorten(equations%low(i), equations%high(i), joint%material%s0, box(balance%free(i)))
      end do
    end associate
  end subroutine examine_box

  !> Shorten a side of a box to a range of its coordinate, and a little more because of rounding errors. Round an
  !> equilibrium at zero it would become so short that products of the equations vanish.
  pure subroutine shorten(from, to, s0, side)
    real(wp), intent(in) :: from, to          !! -1 to 1
    real(wp), intent(in) :: s0                !! length with which separations are compared
    type(range_type), intent(inout) :: side   !! separations
    real(wp), parameter :: rounding = 32.0_wp*epsilon(1.0_wp)
    real(wp) :: error, half, middle
    half = 0.5_wp*(side%high - side%low)
    middle = side%low + half
    error = rounding*(max(-side%low, side%high) + s0)
    side%low = max(side%low, middle + from*half - error)
    side%high = min(side%high, middle + to*half + error)
  end subroutine shorten

end module asperity_exclusion
