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
  !> The increments: without a change, then there and back for each component to either side.
  integer, parameter :: n_probes = 6, n_tries = 2*n_probes + 1
  !> Traction of a virgin point without separation that is no rounding error, relative to the strength.
  real(wp), parameter :: at_rest = 1.0e-9_wp

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
  pure function negative(i, stiffness, law) result(text)
    integer, intent(in) :: i                  !! component
    real(wp), intent(in) :: stiffness         !! the stiffness
    class(foreign_law), intent(in) :: law     !! the law
    character(len=:), allocatable :: text
    text = "d t_" // trim(component_names(i)) // "/d s_" // trim(component_names(i)) // " = " // short(stiffness) // &
      " of its DDSDDE: expected a positive stiffness, about stiffness = " // short(law%stiffness)
  end function negative

  !> Try small separations of a virgin point: the stiffness must be positive and near the declared one, and the traction
  !> must follow it.
  subroutine try_stiffness(path, good, text)
    type(checked_path_type), intent(in) :: path                !! the path, whose law is tried
    logical, intent(out) :: good                               !! whether it passes
    character(len=:), allocatable, intent(out) :: text         !! what was found
    type(walk_type) :: plan
    real(wp), allocatable :: results(:, :)
    real(wp) :: d, s, t
    real(wp) :: stiffness(n_probes)
    integer :: i, j
    plan%path = path
    plan%factors = reshape([1.0_wp, 1.0_wp, 1.0_wp], [3, 1])
    associate (law => path%law)
      plan%path%start = law%virgin()
      ! that of this project begins at the state of the case
      if (len(law%umat%library) == 0) plan%path%start = 0.0_wp
      plan%path%dt = spread(1.0_wp, 1, n_tries)
      if (size(path%dt) > 0) plan%path%dt = path%dt(1)
      plan%path%step = spread(1, 1, n_tries)
      plan%path%increment = [(i, i=1, n_tries)]
      plan%path%s = reshape([(0.0_wp, i=1, 3*(n_tries + 1))], [3, n_tries + 1])
      do i = 2, n_tries, 2
        j = (i + 2)/4
        if (law%umat%position(j) > 0) plan%path%s(j, i + 1) = small*law%s_0*merge(1.0_wp, -1.0_wp, mod(i, 4) == 0)
      end do
      call walk(plan, results, text)
      good = len(text) == 0
      if (.not. good) return
      good = maxval(abs(results(:3, 1))) <= at_rest*law%stress
      text = "the traction without separation is up to " // short(maxval(abs(results(:3, 1)))) // ": expected 0"
      if (.not. good) return
      stiffness = 0.0_wp
      do i = 2, n_tries, 2
        j = (i + 2)/4
        if (law%umat%position(j) == 0) cycle
        d = results(4*j, i)
        s = plan%path%s(j, i + 1)
        t = results(j, i)
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
        stiffness(i/2) = d
      end do
      associate (probed => stiffness(:2*count(law%umat%position > 0)))
        text = "d t/d s is " // short(minval(probed)) // " to " // short(maxval(probed)) // " at small separations"
        ! the UMAT of this project may be that of a joint without a bond
        good = any(abs(log(max(probed, tiny(probed))/law%stiffness)) <= log(near)) .or. &
          (len(law%umat%library) == 0 .and. any(probed > 0.0_wp))
        if (.not. good) text = text // ": expected stiffness = " // short(law%stiffness)
        if (size(probed) == 4 .or. .not. good) return
        good = all(probed(3:) > 0.0_wp) .or. all(probed(3:) <= 0.0_wp)
        if (.not. good) text = "DDSDDE has a stiffness in one direction of slip and none in another one"
      end associate
    end associate
  end subroutine try_stiffness

end module asperity_umat_stiffness
