!> Joints of Cast3M, which calls them as MTest's interface `castem` does: by the arguments of Abaqus' UMAT.
!>
!> What differs: integers of the size of a long, components (Tx, N) or (Tx, Ty, N), separations in place of strains,
!> four constants of Cast3M before those of the law, a return value (1: done) in KINC, and NULL for all that is not
!> named here. The water pressure of a wet joint is the first of PREDEF. The joint is the behaviour of asperity_generic.
module asperity_castem
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_long, &
    c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: error_unit
  use asperity_contract, only: n_statev
  use asperity_generic, only: asperity_generic_joint, material_properties, point_view, state_view
  use asperity_host, only: pressure_at_end, quiet_nan
  use asperity_text, only: integer_text
  implicit none
  private
  public :: asperity_castem_joint

  !> Constants of Cast3M before those of the law: stiffness in shear and in opening, density, thermal expansion.
  integer, parameter, public :: n_leading = 4
  !> Request for the consistent tangent.
  real(c_double), parameter :: consistent = 4.0_c_double

contains

  !> Traction, state and tangent at the end of an increment; returns 1, or -1 with a message on standard error, where
  !> nothing but PNEWDT is written.
  function asperity_castem_joint(n_planes, wet, stress, statev, ddsdde, stran, dstran, dtime, predef, dpred, ntens, &
                                 nstatv, props, nprops, pnewdt) bind(C) result(done)
    integer(c_int), value :: n_planes                          !! number of planes
    integer(c_int), value :: wet                               !! 1: with water, 0: without
    integer(c_long), intent(in) :: ntens, nstatv, nprops       !! sizes of the arrays
    real(c_double), intent(inout), target :: stress(ntens)     !! traction, start -> end
    real(c_double), intent(inout), target :: statev(nstatv)    !! state, start -> end
    real(c_double), intent(inout) :: ddsdde(ntens, ntens)      !! d traction_i/d separation_j
    real(c_double), intent(in) :: stran(ntens)                 !! separation at the start
    real(c_double), intent(in) :: dstran(ntens)                !! its increment
    real(c_double), intent(in) :: dtime                        !! duration
    type(c_ptr), value :: predef                               !! water pressure of a wet joint at the start, else any
    type(c_ptr), value :: dpred                                !! its increment
    real(c_double), intent(in), target :: props(nprops)        !! constants
    type(c_ptr), value :: pnewdt                               !! factor of the next time step, may be NULL
    integer(c_int) :: done
    real(c_double), target :: end(3), force(3), new_force(3), operator(9), start(3), state(nstatv), p(2)
    real(c_double), pointer :: field
    type(point_view) :: point
    type(state_view) :: new, old
    type(c_ptr) :: law   ! its constants
    integer :: i, j, n, order(3), n_props
    done = -1
    n = int(ntens)
    n_props = n_leading + count(material_properties(.false.))
    if (n /= 2 .and. n /= 3) then
      write (error_unit, "(2a)") "asperity castem: NTENS = ", integer_text(n) // ": expected a joint element, 2 or 3"
    else if (nprops /= n_props .or. nstatv /= n_statev(int(n_planes), .true., .true.)) then
      write (error_unit, "(2a)") "asperity castem: NPROPS = ", integer_text(int(nprops)) // ", NSTATV = " // &
        integer_text(int(nstatv)) // ": expected " // integer_text(n_props) // " and " // &
        integer_text(n_statev(int(n_planes), .true., .true.)) // ", as asperity card cast3m writes them"
    else
      order = [n, 1, 2]   ! of N, Tx, Ty
      start(:n) = stran(order(:n))
      end(:n) = start(:n) + dstran(order(:n))
      force(:n) = stress(order(:n))
      new_force = 0.0_c_double
      operator = 0.0_c_double
      operator(1) = consistent
      state = statev
      law = c_loc(props(n_leading + 1))
      p = quiet_nan
      if (wet == 1 .and. c_associated(predef) .and. c_associated(dpred)) then
        call c_f_pointer(predef, field)
        p(1) = field
        call c_f_pointer(dpred, field)
        p(2) = pressure_at_end(p(1), field)
      end if
      old = state_view(c_loc(start), c_loc(force), c_null_ptr, law, c_loc(statev), c_null_ptr, c_null_ptr, c_loc(p(1)))
      new = state_view(c_loc(end), c_loc(new_force), c_null_ptr, law, c_loc(state), c_null_ptr, c_null_ptr, c_loc(p(2)))
      point = point_view(c_null_ptr, dtime, c_loc(operator), pnewdt, c_null_ptr, old, new)
      done = asperity_generic_joint(point, n_planes, int(n, c_int), wet)
    end if
    if (done /= 1) then
      flush (error_unit)
      return
    end if
    statev = state
    stress(order(:n)) = new_force(:n)
    do j = 1, n
      do i = 1, n
        ddsdde(order(i), order(j)) = operator(n*(i - 1) + j)
      end do
    end do
  end function asperity_castem_joint

end module asperity_castem
