!> The user routines as a host declares them.
module host_routines
  use asperity_kinds, only: wp
  implicit none
  private
  public :: umat

  interface
    !> UMAT; hosts may leave out (pass NULL for) what is optional here.
    subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, &
                    temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, &
                    celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
      import :: wp
      implicit none
      integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops
      real(wp), intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd
      real(wp), intent(in) :: stran(ntens), dstran(ntens), props(nprops)
      character(len=80), intent(in) :: cmname
      real(wp), intent(inout), optional :: pnewdt, rpl, ddsddt(*), drplde(*), drpldt
      real(wp), intent(in), optional :: time(*), dtime, temp, dtemp, predef(*), dpred(*), coords(*), drot(*), celent, &
        dfgrd0(*), dfgrd1(*)
      integer, intent(in), optional :: noel, npt, layer, kspt, kstep, kinc
    end subroutine umat
  end interface

end module host_routines
