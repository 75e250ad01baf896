!> User routines in a shared library, found by their names as Abaqus finds them.
module user_library
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_funptr, c_int, c_null_char, c_ptr
  use, intrinsic :: iso_fortran_env, only: real32, real64
  implicit none
  private
  public :: load_umat, load_vumat, load_vumat_single, has, umat_call, vumat_call, vumat_single_call

  abstract interface
    !> UMAT as Abaqus/Standard calls it: every argument is there.
    subroutine umat_call(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, &
                         dtime, temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, &
                         drot, pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
      import :: real64
      implicit none
      integer, intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep, kinc
      real(real64), intent(inout) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), sse, spd, scd, rpl, &
        ddsddt(ntens), drplde(ntens), drpldt, pnewdt
      real(real64), intent(in) :: stran(ntens), dstran(ntens), time(2), dtime, temp, dtemp, predef(1), dpred(1), &
        props(nprops), coords(3), drot(3, 3), celent, dfgrd0(3, 3), dfgrd1(3, 3)
      character(len=80), intent(in) :: cmname
    end subroutine umat_call

    !> VUMAT as Abaqus/Explicit calls it in double precision.
    subroutine vumat_call(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, &
                          coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, &
                          defgradOld, fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, &
                          stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, enerInelasNew)
      import :: real64
      implicit none
      integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(real64), intent(in) :: stepTime, totalTime, dt
      character(len=80), intent(in) :: cmname
      real(real64), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock), &
        strainInc(nblock, ndir + nshr), relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), &
        defgradOld(nblock, *), fieldOld(nblock, *), stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), &
        enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, *), &
        defgradNew(nblock, *), fieldNew(nblock, *)
      real(real64), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), &
        enerInternNew(nblock), enerInelasNew(nblock)
    end subroutine vumat_call

    !> VUMAT as Abaqus/Explicit calls it in single precision.
    subroutine vumat_single_call(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, &
                                 cmname, coordMp, charLength, props, density, strainInc, relSpinInc, tempOld, &
                                 stretchOld, defgradOld, fieldOld, stressOld, stateOld, enerInternOld, enerInelasOld, &
                                 tempNew, stretchNew, defgradNew, fieldNew, stressNew, stateNew, enerInternNew, &
                                 enerInelasNew)
      import :: real32
      implicit none
      integer, intent(in) :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(real32), intent(in) :: stepTime, totalTime, dt
      character(len=80), intent(in) :: cmname
      real(real32), intent(in) :: coordMp(nblock, *), charLength(nblock), props(nprops), density(nblock), &
        strainInc(nblock, ndir + nshr), relSpinInc(nblock, *), tempOld(nblock), stretchOld(nblock, *), &
        defgradOld(nblock, *), fieldOld(nblock, *), stressOld(nblock, ndir + nshr), stateOld(nblock, nstatev), &
        enerInternOld(nblock), enerInelasOld(nblock), tempNew(nblock), stretchNew(nblock, *), &
        defgradNew(nblock, *), fieldNew(nblock, *)
      real(real32), intent(inout) :: stressNew(nblock, ndir + nshr), stateNew(nblock, nstatev), &
        enerInternNew(nblock), enerInelasNew(nblock)
    end subroutine vumat_single_call
  end interface

  !> Load at once all that the library needs; its names stay its own.
  integer(c_int), parameter :: rtld_now = 2_c_int

  interface
    !> POSIX.
    function dlopen(path, flags) bind(C)
      import :: c_char, c_int, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: flags
      type(c_ptr) :: dlopen
    end function dlopen

    !> POSIX.
    function dlsym(handle, name) bind(C)
      import :: c_char, c_funptr, c_ptr
      implicit none
      type(c_ptr), value :: handle
      character(kind=c_char), intent(in) :: name(*)
      type(c_funptr) :: dlsym
    end function dlsym
  end interface

contains

  !> Whether a library has a routine.
  function has(path, name) result(yes)
    character(len=*), intent(in) :: path   !! library
    character(len=*), intent(in) :: name   !! symbol
    logical :: yes
    yes = c_associated(dlsym(handle_of(path), name // c_null_char))
  end function has

  !> UMAT of a library.
  subroutine load_umat(path, routine)
    character(len=*), intent(in) :: path                    !! library
    procedure(umat_call), pointer, intent(out) :: routine   !! its umat_
    call c_f_procpointer(symbol(path, "umat_"), routine)
  end subroutine load_umat

  !> VUMAT of a library in double precision.
  subroutine load_vumat(path, routine)
    character(len=*), intent(in) :: path                     !! library
    procedure(vumat_call), pointer, intent(out) :: routine   !! its vumat_
    call c_f_procpointer(symbol(path, "vumat_"), routine)
  end subroutine load_vumat

  !> VUMAT of a library in single precision, by the name given.
  subroutine load_vumat_single(path, routine, name)
    character(len=*), intent(in) :: path                            !! library
    procedure(vumat_single_call), pointer, intent(out) :: routine   !! the routine
    character(len=*), intent(in) :: name                            !! its symbol
    call c_f_procpointer(symbol(path, name), routine)
  end subroutine load_vumat_single

  !> Address of a routine; the program ends if there is none.
  function symbol(path, name) result(address)
    character(len=*), intent(in) :: path   !! library
    character(len=*), intent(in) :: name   !! symbol
    type(c_funptr) :: address
    address = dlsym(handle_of(path), name // c_null_char)
    if (.not. c_associated(address)) error stop "user_library: " // path // ": no " // name
  end function symbol

  !> Handle of a library; the program ends if it cannot be loaded.
  function handle_of(path) result(handle)
    character(len=*), intent(in) :: path   !! library
    type(c_ptr) :: handle
    handle = dlopen(path // c_null_char, rtld_now)
    if (.not. c_associated(handle)) error stop "user_library: cannot load " // path
  end function handle_of

end module user_library
