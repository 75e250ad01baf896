!> Vectors in the axes of a plane and of the interface.
module asperity_axes
  use asperity_kinds, only: wp
  use asperity_types, only: local_type, plane_type, vector_type
  implicit none
  private
  public :: global_traction, in_axes, local_separation, square, uphill

contains

  !> Separation of a plane in its axes (2); every plane has the separation of the interface.
  pure function local_separation(plane, s) result(local)
    type(plane_type), intent(in) :: plane   !! axes
    type(vector_type), intent(in) :: s      !! separation of the interface, length
    type(local_type) :: local
    local%n = plane%n%n*s%n + (plane%n%x*s%x + plane%n%y*s%y)
    local%t = plane%t%n*s%n + (plane%t%x*s%x + plane%t%y*s%y)
    local%h = plane%h%x*s%x + plane%h%y*s%y
  end function local_separation

  !> Traction of a plane in the axes of the interface: its term in (3) without the weight.
  pure function global_traction(plane, sigma) result(traction)
    type(plane_type), intent(in) :: plane   !! axes
    type(local_type), intent(in) :: sigma   !! traction of the plane
    type(vector_type) :: traction
    traction%n = plane%n%n*sigma%n + plane%t%n*sigma%t
    traction%x = plane%n%x*sigma%n + (plane%t%x*sigma%t + plane%h%x*sigma%h)
    traction%y = plane%n%y*sigma%n + (plane%t%y*sigma%t + plane%h%y*sigma%h)
  end function global_traction

  !> A vector with components along (N, e, h), in the axes of the interface.
  pure function in_axes(plane, a) result(b)
    type(plane_type), intent(in) :: plane   !! axes
    type(local_type), intent(in) :: a       !! vector
    type(vector_type) :: b
    b = vector_type(a%n, plane%e_x*a%t + plane%h%x*a%h, plane%e_y*a%t + plane%h%y*a%h)
  end function in_axes

  !> Component of a separation along the direction in which a plane rises.
  pure function uphill(plane, s) result(u)
    type(plane_type), intent(in) :: plane   !! axes
    type(vector_type), intent(in) :: s      !! separation of the interface, length
    real(wp) :: u
    u = plane%e_x*s%x + plane%e_y*s%y
  end function uphill

  !> Square of the norm of a vector.
  pure function square(s) result(norm_2)
    type(local_type), intent(in) :: s   !! the vector
    real(wp) :: norm_2
    norm_2 = s%n**2 + (s%t**2 + s%h**2)
  end function square

end module asperity_axes
