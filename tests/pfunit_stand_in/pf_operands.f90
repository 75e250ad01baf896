!> Operands of the assertions of funit: values of several kinds and ranks in one form, and as text.
module pf_operands
   use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
   implicit none
   private

   public :: operand_type, pf_value, is_nan, is_finite, list_text, element_text, trimmed

   !> Operand of an assertion: kind, extents (none for a scalar), elements in array order, or a text.
   type :: operand_type
      character(len=9) :: kind = ""
      integer, allocatable :: extents(:)
      real(real64), allocatable :: v(:)
      character(len=:), allocatable :: text
   end type operand_type

   !> Operand from an expression of rank 0 to 2 (text: rank 0).
   interface pf_value
      module procedure real64_0, real64_1, real64_2, real32_0, real32_1, real32_2
      module procedure integer_0, integer_1, integer_2, logical_0, logical_1, logical_2, character_0
   end interface pf_value

   ! NaN and infinity are recognised by their bits: comparing a signalling NaN, even by ieee_is_nan, would trap.
   integer(int64), parameter :: infinity_bits = int(z'7FF0000000000000', int64)
   integer(int32), parameter :: infinity_bits_32 = int(z'7F800000', int32)

contains

   !> Operand of kind real64, rank 0.
   pure function real64_0(x) result(operand)
      real(real64), intent(in) :: x  !! any value
      type(operand_type) :: operand
      call fill(operand, "real64", shape(x), [x])
   end function real64_0

   !> Operand of kind real64, rank 1.
   pure function real64_1(x) result(operand)
      real(real64), intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      call fill(operand, "real64", shape(x), [x])
   end function real64_1

   !> Operand of kind real64, rank 2.
   pure function real64_2(x) result(operand)
      real(real64), intent(in) :: x(:, :)  !! any values
      type(operand_type) :: operand
      call fill(operand, "real64", shape(x), [x])
   end function real64_2

   !> Operand of kind real32, rank 0.
   pure function real32_0(x) result(operand)
      real(real32), intent(in) :: x  !! any value
      type(operand_type) :: operand
      call fill(operand, "real32", shape(x), [widened(x)])
   end function real32_0

   !> Operand of kind real32, rank 1.
   pure function real32_1(x) result(operand)
      real(real32), intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      call fill(operand, "real32", shape(x), [widened(x)])
   end function real32_1

   !> Operand of kind real32, rank 2.
   pure function real32_2(x) result(operand)
      real(real32), intent(in) :: x(:, :)  !! any values
      type(operand_type) :: operand
      call fill(operand, "real32", shape(x), [widened(x)])
   end function real32_2

   !> Operand of kind integer, rank 0.
   pure function integer_0(x) result(operand)
      integer, intent(in) :: x  !! any value
      type(operand_type) :: operand
      call fill(operand, "integer", shape(x), [real(x, real64)])
   end function integer_0

   !> Operand of kind integer, rank 1.
   pure function integer_1(x) result(operand)
      integer, intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      call fill(operand, "integer", shape(x), [real(x, real64)])
   end function integer_1

   !> Operand of kind integer, rank 2.
   pure function integer_2(x) result(operand)
      integer, intent(in) :: x(:, :)  !! any values
      type(operand_type) :: operand
      call fill(operand, "integer", shape(x), [real(x, real64)])
   end function integer_2

   !> Operand of kind logical, rank 0.
   pure function logical_0(x) result(operand)
      logical, intent(in) :: x  !! any value
      type(operand_type) :: operand
      call fill(operand, "logical", shape(x), [bit(x)])
   end function logical_0

   !> Operand of kind logical, rank 1.
   pure function logical_1(x) result(operand)
      logical, intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      call fill(operand, "logical", shape(x), [bit(x)])
   end function logical_1

   !> Operand of kind logical, rank 2.
   pure function logical_2(x) result(operand)
      logical, intent(in) :: x(:, :)  !! any values
      type(operand_type) :: operand
      call fill(operand, "logical", shape(x), [bit(x)])
   end function logical_2

   !> Operand of kind character, rank 0.
   pure function character_0(x) result(operand)
      character(len=*), intent(in) :: x  !! any text
      type(operand_type) :: operand
      call fill(operand, "character", shape(x), [0.0_real64])
      operand%text = x
   end function character_0

   !> Set the components of an operand.
   pure subroutine fill(operand, kind, extents, v)
      type(operand_type), intent(out) :: operand  !! operand whose components are set
      character(len=*), intent(in) :: kind        !! name of the kind
      integer, intent(in) :: extents(:)           !! shape
      real(real64), intent(in) :: v(:)            !! elements
      operand%kind = kind
      operand%extents = extents
      operand%v = v
   end subroutine fill

   !> Convert real32 to real64. A signalling NaN does not trap.
   elemental function widened(x) result(y)
      real(real32), intent(in) :: x  !! any value
      real(real64) :: y
      if (iand(transfer(x, 0_int32), huge(0_int32)) > infinity_bits_32) then
         y = transfer(huge(0_int64), y)
      else
         y = real(x, real64)
      end if
   end function widened

   !> Logical as 1 or 0.
   elemental function bit(x) result(y)
      logical, intent(in) :: x  !! any value
      real(real64) :: y
      y = merge(1.0_real64, 0.0_real64, x)
   end function bit

   !> Text without blanks and tabs at its ends.
   pure function trimmed(text) result(s)
      character(len=*), intent(in) :: text  !! any text
      character(len=:), allocatable :: s
      character(len=*), parameter :: white = " "//achar(9)
      s = text(:verify(text, white, back=.true.))
      if (len(s) > 0) s = s(verify(s, white):)
   end function trimmed

   !> Integers as text, separated by commas.
   pure function list_text(list) result(s)
      integer, intent(in) :: list(:)  !! any values
      character(len=:), allocatable :: s
      character(len=40) :: buffer
      write (buffer, '(*(i0, :, ","))') list
      s = trim(buffer)
   end function list_text

   !> Element as text.
   pure function element_text(x, kind) result(s)
      real(real64), intent(in) :: x         !! element
      character(len=*), intent(in) :: kind  !! kind of its operand
      character(len=:), allocatable :: s
      character(len=40) :: buffer
      if (is_nan(x)) then
         buffer = "NaN"
      else if (kind == "integer") then
         write (buffer, "(i0)") nint(x)
      else if (kind == "logical") then
         buffer = merge("true ", "false", x > 0.5_real64)
      else if (kind == "real32" .and. is_finite(x)) then
         write (buffer, "(g0)") real(x, real32)
      else
         write (buffer, "(g0)") x
      end if
      s = trim(buffer)
   end function element_text

   !> Whether x is a NaN, quiet or signalling.
   elemental function is_nan(x) result(yes)
      real(real64), intent(in) :: x  !! any value
      logical :: yes
      yes = iand(transfer(x, 0_int64), huge(0_int64)) > infinity_bits
   end function is_nan

   !> Whether x is neither NaN nor infinite.
   elemental function is_finite(x) result(yes)
      real(real64), intent(in) :: x  !! any value
      logical :: yes
      yes = iand(transfer(x, 0_int64), huge(0_int64)) < infinity_bits
   end function is_finite

end module pf_operands
