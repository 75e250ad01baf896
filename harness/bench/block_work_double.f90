!> Block kernel, VUMAT and their limits in double precision.
module block_work_double
  use, intrinsic :: iso_fortran_env, only: wp => real64, real64
  use asperity_block_double, only: block_type, chunk, new_block, update_block
  use asperity_contract, only: v_offset
  use asperity_interface, only: interface_type
  use host_routines, only: vumat
  use scene, only: new_scene, slip
  use shortcuts, only: update_frictionless, update_virgin
  implicit none
  private
  public :: block_work_type, new_block_work, run_block, run_roots, large_work_type, new_large_work, run_vumat, &
    run_stream, run_shortcut
  include "block_work.inc"

!> A prototype of a shortcut in place of the block kernel; the scene is that of the block kernel.
pure subroutine run_shortcut(work, friction, used)
  type(block_work_type), intent(inout) :: work   !! the points
  logical, intent(in) :: friction                !! virgin planes with friction, or damaged ones without
  real(real64), intent(inout) :: used            !! sum of results
  real(wp) :: sums(chunk, 7)
  integer :: first, i, j, k
  do i = 1, size(work%s1, 3)
    first = chunk*(i - 1) + 1
    do j = 1, size(work%old, 2)
      do k = first, first + chunk - 1
        work%new(k, j) = work%old(k, j)
      end do
    end do
    if (friction) then
      call update_virgin(work%block, chunk, work%s0(:, :, i), work%s1(:, :, i), work%n_points, work%new(first, 1), sums)
    else
      call update_frictionless(work%block, chunk, work%s0(:, :, i), work%s1(:, :, i), work%n_points, &
        work%new(first, 1), sums)
    end if
    work%traction(:, :, i) = sums(:, 1:3)
    used = used + sums(1, 1) + sums(1, 5)
  end do
end subroutine run_shortcut

end module block_work_double
