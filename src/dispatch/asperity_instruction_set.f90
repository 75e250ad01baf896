!> Instruction set of the kernels that run.
module asperity_instruction_set
  implicit none
  private
  public :: instruction_set
  interface
    !> Level of x86-64 that was chosen when the library was loaded (instruction_set.c): 1 or 3.
    pure function instruction_set() bind(c, name="asperity_isa") result(level)
      use, intrinsic :: iso_c_binding, only: c_int
      implicit none
      integer(c_int) :: level
    end function instruction_set
  end interface
end module asperity_instruction_set
