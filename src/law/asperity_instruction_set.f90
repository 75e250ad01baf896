!> Instruction set of the kernels that run.
module asperity_instruction_set
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private
  public :: instruction_set
contains
  !> Level of x86-64 that was chosen when the library was loaded: 1, or 3 (AVX2, FMA); 0: the library has one set of
  !> kernels.
  pure function instruction_set() bind(c, name="asperity_isa") result(level)
    integer(c_int) :: level
    level = 0_c_int
  end function instruction_set
end module asperity_instruction_set
