!> The kernels of the law: which one a plane needs, and the constants with its flags.
module asperity_kernels
  use asperity_kinds, only: wp
  use asperity_types, only: material_type, mild_slope
  implicit none
  private
  public :: exact_kernel, kernel_constants, kernel_of

  !> Kernels: what a plane needs besides damage and friction. A loop has a literal one, so that its body has no
  !> branches.
  integer, parameter, public :: kernel_straight = 0   !! nothing
  integer, parameter, public :: kernel_guarded = 1    !! the guard
  integer, parameter, public :: kernel_facet = 2      !! a facet of a mild slope
  integer, parameter, public :: kernel_worn = 3       !! a facet of any slope, which may wear
  integer, parameter, public :: kernel_general = 4    !! everything but a dashpot: the guard and hyperbolic contact, too
  integer, parameter, public :: kernel_damped = 5     !! everything

contains

  !> Kernel for a plane of this slope.
  pure function kernel_of(material, slope) result(kernel)
    type(material_type), intent(in) :: material   !! constants of the law
    real(wp), intent(in) :: slope                 !! tan(theta)
    integer :: kernel
    if (material%damps) then
      kernel = kernel_damped
    else if (material%hyperbolic .or. (material%guard .and. material%curved)) then
      kernel = kernel_general
    else if (material%guard) then
      kernel = kernel_guarded
    else if (.not. (material%curved .and. slope > 0.0_wp)) then
      kernel = kernel_straight
    else if (material%wears .or. slope > mild_slope) then
      kernel = kernel_worn
    else
      kernel = kernel_facet
    end if
  end function kernel_of

  !> Kernel for the accounts of long increments beside another one: three are enough, as these are rare.
  pure function exact_kernel(kernel) result(exact)
    integer, intent(in) :: kernel   !! the other one
    integer :: exact
    exact = merge(kernel, kernel_general, kernel == kernel_straight .or. kernel == kernel_damped)
  end function exact_kernel

  !> Constants with the flags of a kernel.
  pure function kernel_constants(source, kernel, by_points, exact) result(m)
    type(material_type), intent(in) :: source   !! the constants
    integer, intent(in) :: kernel               !! which one, a literal
    logical, intent(in) :: by_points, exact     !! components of material_type, literals
    type(material_type) :: m
    m = source
    m%guard = kernel == kernel_guarded .or. kernel >= kernel_general
    m%general = kernel >= kernel_facet
    m%wears = kernel >= kernel_worn
    m%hyperbolic = kernel >= kernel_general
    m%damps = kernel == kernel_damped
    m%by_points = by_points
    m%exact = exact
  end function kernel_constants

end module asperity_kernels
