!> The first stiffness of a UMAT: that of a virgin point, which `stiffness` of &umat declares.
module asperity_umat_stiffness
  use asperity_equations, only: point_type
  use asperity_foreign_umat, only: foreign_law, n_header
  use asperity_kinds, only: wp
  use asperity_steps, only: component_names
  use asperity_text, only: short
  use asperity_umat_walk, only: checked_path_type, walk, walk_type
  implicit none
  private
  public :: stiffness_fault, try_stiffness

  !> Largest ratio of stiffness and declared stiffness, either way, with which a load path is taken: another unit is
  !> admissible, numbers of another precision are not.
  real(wp), parameter :: other_unit = 1.0e6_wp
  !> The same for the check.
  real(wp), parameter :: near = 2.0_wp
  !> Separations of the check, relative to `length`; the virgin law is nearly linear there: largest part of the traction
  !> that is not.
  real(wp), parameter :: small = 1.0e-3_wp, curvature = 0.05_wp
  !> The separations: at rest, closed, opened, sheared in both directions, each with the way back.
  integer, parameter :: n_tries = 9, closed = 2, component(2:n_tries) = [1, 1, 1, 1, 2, 2, 3, 3]
  real(wp), parameter :: size_of(2:n_tries) = [-1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]

contains

  !> What is wrong with the tangent of a virgin point, so that no load path is taken; empty: nothing, or the point is
  !> not virgin.
  pure function stiffness_fault(law, point) result(text)
    class(foreign_law), intent(in) :: law     !! the law
    type(point_type), intent(in) :: point     !! at the start of a path
    character(len=:), allocatable :: text
    real(wp) :: largest
    integer :: i
    text = ""
    if (any(abs([law%umat%first, point%state(n_header + 1:)]) > 0.0_wp)) return
    do i = 1, 3
      if (point%tangent(i, i) < -law%stiffness/other_unit) text = negative(i, point%tangent(i, i), law)
    end do
    largest = maxval(abs(point%tangent))
    if (largest*other_unit < law%stiffness .or. largest > other_unit*law%stiffness) text = "the largest number of " // &
      "DDSDDE is " // short(largest) // ": expected about stiffness = " // short(law%stiffness) // &
      ", in double precision"
  end function stiffness_fault

  !> Text on a negative stiffness.
  pure function negative(i, found, law) result(text)
    integer, intent(in) :: i                  !! component
    real(wp), intent(in) :: found             !! the stiffness
    class(foreign_law), intent(in) :: law     !! the law
    character(len=:), allocatable :: text
    text = "d t_" // trim(component_names(i)) // "/d s_" // trim(component_names(i)) // " = " // short(found) // &
      " of its DDSDDE: expected a positive stiffness, about stiffness = " // short(law%stiffness)
  end function negative

  !> Try small separations of a virgin point: the stiffness must be positive and near the declared one, and the traction
  !> must follow it.
  subroutine try_stiffness(path, good, text)
    type(checked_path_type), intent(in) :: path                !! the path, whose law is tried
    logical, intent(out) :: good                               !! whether it passes
    character(len=:), allocatable, intent(out) :: text         !! what was found
    type(walk_type) :: plan
    real(wp), allocatable :: found(:, :)
    real(wp) :: d, s, t
    real(wp) :: stiffness(4)
    integer :: i, j, n
    plan%path = path
    plan%factors = reshape([1.0_wp, 1.0_wp, 1.0_wp], [3, 1])
    associate (law => path%law)
      plan%path%start = law%virgin()
      plan%path%dt = spread(1.0_wp, 1, n_tries)
      if (size(path%dt) > 0) plan%path%dt = path%dt(1)
      plan%path%step = spread(1, 1, n_tries)
      plan%path%increment = [(i, i=1, n_tries)]
      plan%path%s = reshape([(0.0_wp, i=1, 3*(n_tries + 1))], [3, n_tries + 1])
      do i = 2, n_tries
        plan%path%s(component(i), i + 1) = small*law%length*size_of(i)
      end do
      call walk(plan, found, text)
      good = len(text) == 0
      if (.not. good) return
      n = 0
      do i = 2, n_tries, 2
        j = component(i)
        if (law%umat%position(j) == 0) cycle
        d = found(4*j, i)
        s = small*law%length*size_of(i)
        t = found(j, i) - found(j, 1)
        good = .false.
        if (d < 0.0_wp) then
          text = negative(j, d, law)
        else if (abs(t - d*s) > curvature*max(abs(t), abs(d*s))) then
          text = "at s_" // trim(component_names(j)) // " = " // short(s) // " the traction is " // short(t) // &
            " where DDSDDE gives " // short(d*s)
        else
          good = .true.
        end if
        if (.not. good) return
        n = n + 1
        stiffness(n) = d
      end do
      associate (ratio => stiffness(:n)/law%stiffness)
        text = "d t/d s is " // short(minval(stiffness(:n))) // " to " // short(maxval(stiffness(:n))) // &
          " at small separations"
        ! the UMAT of this project may be that of a joint without a bond
        good = any(ratio >= 1.0_wp/near .and. ratio <= near) .or. &
          (len(law%umat%library) == 0 .and. any(ratio > 0.0_wp))
        if (.not. good) text = text // ": expected stiffness = " // short(law%stiffness)
      end associate
    end associate
  end subroutine try_stiffness

end module asperity_umat_stiffness
