!> UMAT for support_umat.py: a bilinear law whose tangent is not symmetric, with a fault on request. PROPS: stiffness,
!> s0, sf, weight of the shears in the damage, fault. STATEV: damage, largest separation, KSTEP, KINC, TIME, DTIME.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
  double precision :: stress(ntens), statev(*), ddsdde(ntens, ntens), sse, spd, scd, rpl, ddsddt(ntens), drplde(ntens), &
    drpldt, stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), props(*), coords(3), &
    drot(3, 3), pnewdt, celent, dfgrd0(3, 3), dfgrd1(3, 3)
  character(len=80) :: cmname
  integer :: fault
  double precision, save :: saved = 0d0
  double precision :: d, d_old, k, largest, lambda, old(3), s(3), s0, sf, slope, w(3)
  integer :: at(3), i, j, n
  fault = nint(props(5))
  if (fault == 19 .and. .not. saved > 0d0 .or. fault == 20 .and. kinc == 1) statev(:2) = 0d0
  if (fault == 19) saved = 1d0
  at = [1, 2, 3]
  if (ntens == 6) at = [3, 5, 6]
  n = min(ntens, 3)
  k = props(1)
  s0 = props(2)
  sf = props(3)
  w = [1d0, props(4), props(4)]
  s = 0d0
  old = 0d0
  s(:n) = stran(at(:n)) + dstran(at(:n))
  old(:n) = stran(at(:n))
  lambda = sqrt(max(s(1), 0d0)**2 + sum(w(2:)*s(2:)**2))
  d_old = statev(1)
  largest = max(statev(2), lambda)
  if (fault == 2) then
    saved = max(saved, largest)
    largest = saved
  else if (fault == 3) then
    largest = lambda
  end if
  d = 0d0
  slope = 0d0
  if (largest > s0) then
    d = min(1d0, sf*(largest - s0)/(largest*(sf - s0)))
    if (d < 1d0 .and. lambda >= largest) slope = sf*s0/(largest**2*(sf - s0))
  end if
  stress = 0d0
  ddsdde = 0d0
  do i = 1, n
    stress(at(i)) = (1d0 - d)*k*s(i)
    ddsdde(at(i), at(i)) = (1d0 - d)*k
  end do
  if (s(1) < 0d0) then
    stress(at(1)) = k*s(1)
    ddsdde(at(1), at(1)) = k
  end if
  do j = 1, n
    do i = 1, n
      if (min(s(1), 0d0) < 0d0 .and. (i == 1 .or. j == 1) .or. .not. slope > 0d0) cycle
      ddsdde(at(i), at(j)) = ddsdde(at(i), at(j)) - k*slope*s(i)*w(j)*s(j)/lambda
    end do
  end do
  if (fault == 1) ddsdde = 0.5d0*(ddsdde + transpose(ddsdde))
  sse = 0.5d0*sum(stress(at(:n))*s(:n))
  old(1) = max(old(1), 0d0)
  s(1) = max(s(1), 0d0)
  scd = scd + 0.25d0*k*(d - d_old)*(sum(s**2) + sum(old**2))
  statev(1) = d
  statev(2) = largest
  if (nstatv >= 7) statev(3:7) = [dble(kstep), dble(kinc), time, dtime]
  select case (fault)
  case (4)
    statev(nstatv + 1) = 1d0
  case (5)
    if (lambda > s0) call xit()
  case (6)
    if (lambda > s0) stress = sqrt(-lambda)
  case (7)
    if (maxval(abs(dstran)) > 0.3d0*s0) then
      pnewdt = 0.4d0
      stress = 1d30
    end if
  case (8)
    stress = stress + 0d0*props(nprops + 1)
  case (9)
    if (lambda > s0) call stdb_abqerr(-3, "no more of this", 0, 0d0, " ")
  case (10)
    celent = 2d0
  case (12)
    if (lambda > s0) stop
  case (13)
    if (ntens == 6) stress = 1.001d0*stress
  case (14)
    if (lambda > s0) pnewdt = 0.999999d0
  case (15)
    if (lambda > s0) pnewdt = sqrt(-lambda)
  case (17)
    if (lambda > s0) error stop
  case (18)
    do while (lambda > s0)
      lambda = max(lambda, s0 + 1d0)
    end do
  case (11)
    stress = stress*(1d0 + 0d0*coords(1))
  end select
end subroutine umat

