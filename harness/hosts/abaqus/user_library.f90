!> User routines of a shared library, found by their names as in Abaqus.
module user_library
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_funptr, c_int, c_null_char, c_ptr
  use host_routines, only: umat, vumat, vumat_single
  implicit none
  private
  public :: load_umat, load_vumat, load_vumat_single, has

  !> Flags of dlopen: resolve all symbols at once, and do not export the symbols of the library.
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
    character(len=*), intent(in) :: path               !! library
    procedure(umat), pointer, intent(out) :: routine   !! its umat_
    call c_f_procpointer(symbol(path, "umat_"), routine)
  end subroutine load_umat

  !> VUMAT of a library in double precision.
  subroutine load_vumat(path, routine)
    character(len=*), intent(in) :: path                !! library
    procedure(vumat), pointer, intent(out) :: routine   !! its vumat_
    call c_f_procpointer(symbol(path, "vumat_"), routine)
  end subroutine load_vumat

  !> VUMAT of a library in single precision, by the name given.
  subroutine load_vumat_single(path, routine, name)
    character(len=*), intent(in) :: path                       !! library
    procedure(vumat_single), pointer, intent(out) :: routine   !! the routine
    character(len=*), intent(in) :: name                       !! its symbol
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
