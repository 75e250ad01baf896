!> Stand-in for pFUnit where it is not installed: the procedures that a translated .pf suite calls. What pFUnit 4.14
!> calls failed fails here, too.
module funit
   use, intrinsic :: iso_fortran_env, only: int64, output_unit, real64
   implicit none
   private

   public :: pf_value, pf_assert, pf_run, pf_finish, output_unit

   !> Operand of an assertion: kind, extents (none for a scalar), elements in array order, or a text.
   type :: operand_type
      character(len=9) :: kind = ""
      integer, allocatable :: extents(:)
      real(real64), allocatable :: v(:)
      character(len=:), allocatable :: text
   end type operand_type

   !> Operand from an expression.
   interface pf_value
      module procedure real64_0, real64_1, real64_2, integer_0, integer_1, logical_0, character_0
   end interface pf_value

   integer(int64), parameter :: infinity_bits = int(z'7FF0000000000000', int64)

   abstract interface
      !> A test.
      subroutine test_procedure()
         implicit none
      end subroutine test_procedure
   end interface

   logical, protected, public :: pf_failed = .false.  ! the running test
   integer :: passed = 0, failed = 0

contains

   !> Operand of kind real64, rank 0.
   pure function real64_0(x) result(operand)
      real(real64), intent(in) :: x  !! any value
      type(operand_type) :: operand
      operand = filled("real64", shape(x), [x])
   end function real64_0

   !> Operand of kind real64, rank 1.
   pure function real64_1(x) result(operand)
      real(real64), intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      operand = filled("real64", shape(x), [x])
   end function real64_1

   !> Operand of kind real64, rank 2.
   pure function real64_2(x) result(operand)
      real(real64), intent(in) :: x(:, :)  !! any values
      type(operand_type) :: operand
      operand = filled("real64", shape(x), [x])
   end function real64_2

   !> Operand of kind integer, rank 0.
   pure function integer_0(x) result(operand)
      integer, intent(in) :: x  !! any value
      type(operand_type) :: operand
      operand = filled("integer", shape(x), [real(x, real64)])
   end function integer_0

   !> Operand of kind integer, rank 1.
   pure function integer_1(x) result(operand)
      integer, intent(in) :: x(:)  !! any values
      type(operand_type) :: operand
      operand = filled("integer", shape(x), real(x, real64))
   end function integer_1

   !> Operand of kind logical, rank 0.
   pure function logical_0(x) result(operand)
      logical, intent(in) :: x  !! any value
      type(operand_type) :: operand
      operand = filled("logical", shape(x), [merge(1.0_real64, 0.0_real64, x)])
   end function logical_0

   !> Operand of kind character, rank 0.
   pure function character_0(x) result(operand)
      character(len=*), intent(in) :: x  !! any text
      type(operand_type) :: operand
      operand = filled("character", shape(x), [0.0_real64])
      operand%text = x
   end function character_0

   !> Operand with these components.
   pure function filled(kind, extents, v) result(operand)
      character(len=*), intent(in) :: kind  !! name of the kind
      integer, intent(in) :: extents(:)     !! shape
      real(real64), intent(in) :: v(:)      !! elements
      type(operand_type) :: operand
      operand%kind = kind
      operand%extents = extents
      operand%v = v
   end function filled

   !> Whether op holds for one pair of elements. A NaN and an infinity fail every assertion.
   pure function compare(op, e, a, t) result(holds)
      character(len=*), intent(in) :: op  !! name of the assertion
      real(real64), intent(in) :: e       !! expected, or left-hand side
      real(real64), intent(in) :: a       !! actual, or right-hand side
      real(real64), intent(in) :: t       !! tolerance
      logical :: holds

      holds = .false.
      if (.not. (is_finite(e) .and. is_finite(a))) return
      select case (op)
      case ("IsFinite")
         holds = .true.
      case ("True")
         holds = a > 0.5_real64
      case ("False")
         holds = a < 0.5_real64
      case ("Equal")
         holds = abs(a - e) <= t
      case ("LessThan")
         holds = e < a
      case ("LessThanOrEqual")
         holds = e <= a
      case ("GreaterThan")
         holds = e > a
      case ("GreaterThanOrEqual")
         holds = e >= a
      case default
      end select
   end function compare

   !> Reason why pFUnit would not compile these operands, or why the tolerance is none. Empty if they fit.
   pure function misfit(op, a, e, t) result(why)
      character(len=*), intent(in) :: op             !! name of the assertion
      type(operand_type), intent(in) :: a            !! actual, or right-hand side
      type(operand_type), intent(in), optional :: e  !! expected, or left-hand side
      type(operand_type), intent(in), optional :: t  !! tolerance
      character(len=:), allocatable :: why, kinds

      why = ""
      kinds = "real64 integer"
      if (op == "True" .or. op == "False") kinds = "integer"
      if (op == "Equal") kinds = "real64 integer logical character"
      if (op == "IsFinite") kinds = "real64"
      if (index(kinds, trim(a%kind)) == 0) why = "operands must be "//kinds//", not "//a%kind
      if (op == "IsFinite" .and. size(a%extents) > 0) why = "the operand must be a scalar"
      if (present(e) .and. why == "") then
         if (e%kind /= a%kind) then
            why = "kinds differ: "//trim(e%kind)//" and "//a%kind
         else if (all(size(e%extents) /= [0, size(a%extents)])) then
            why = "ranks differ"
         else if (any(e%extents /= a%extents(:size(e%extents)))) then
            why = "shapes differ"
         end if
      end if
      if (present(t) .and. why == "") then
         if (a%kind /= "real64" .or. t%kind /= "real64" .or. size(t%extents) > 0) then
            why = "tolerance must be a scalar of the same kind as the operands, real64"
         else if (.not. is_finite(t%v(1))) then
            why = "tolerance must be finite"
         else if (t%v(1) < 0) then
            why = "tolerance must not be negative"
         end if
      end if
   end function misfit

   !> Assert op for all elements, and report the first element that fails.
   subroutine pf_assert(op, file, line, actual, expected, tolerance, message)
      character(len=*), intent(in) :: op                    !! name of the assertion
      character(len=*), intent(in) :: file                  !! name of the .pf file
      integer, intent(in) :: line                           !! line of the directive
      type(operand_type), intent(in) :: actual              !! last operand
      type(operand_type), intent(in), optional :: expected  !! first of two operands
      type(operand_type), intent(in), optional :: tolerance !! default 0
      character(len=*), intent(in), optional :: message     !! text reported with the failure
      character(len=:), allocatable :: why
      real(real64), allocatable :: e(:)
      real(real64) :: t
      integer :: i

      why = misfit(op, actual, expected, tolerance)
      if (why == "" .and. actual%kind == "character") then
         if (expected%text == actual%text) return
         why = "expected <"//expected%text//">, actual <"//actual%text//">"
      else if (why == "") then
         t = 0.0_real64
         if (present(tolerance)) t = tolerance%v(1)
         e = actual%v
         if (present(expected)) e = reshape(expected%v, shape(e), pad=expected%v)
         do i = 1, size(e)
            if (.not. compare(op, e(i), actual%v(i), t)) exit
         end do
         if (i > size(e)) return
      end if
      if (.not. pf_failed) write (output_unit, "(a)") "FAILED"
      pf_failed = .true.
      write (output_unit, "(3a, i0, 2a)") "   ", file, ":", line, ": @assert", op
      if (why /= "") then
         write (output_unit, "(2a)") "      ", why
      else
         if (present(expected)) write (output_unit, "(a, g0)") "      expected ", e(i)
         write (output_unit, "(a, g0)") "      actual   ", actual%v(i)
         if (present(tolerance)) write (output_unit, "(a, g0)") "      within   ", t
         if (size(actual%extents) > 0) write (output_unit, "(a, g0)") "      element  ", i
      end if
      if (present(message)) write (output_unit, "(2a)") "      message  ", message
   end subroutine pf_assert

   !> Run, report and count one test.
   subroutine pf_run(suite, name, test)
      character(len=*), intent(in) :: suite  !! module of the suite
      character(len=*), intent(in) :: name   !! name of the test
      procedure(test_procedure) :: test      !! the test

      write (output_unit, "(a)", advance="no") suite//" "//name//" ... "
      flush (output_unit)
      pf_failed = .false.
      call test()
      if (.not. pf_failed) write (output_unit, "(a)") "ok"
      passed = passed + merge(0, 1, pf_failed)
      failed = failed + merge(1, 0, pf_failed)
   end subroutine pf_run

   !> Print the closing line. The program stops with exit status 1 if a test failed or no test ran.
   subroutine pf_finish()
      write (output_unit, "(i0, a, i0, a)") passed, " passed, ", failed, " failed"
      flush (output_unit)
      if (failed > 0 .or. passed == 0) stop 1
   end subroutine pf_finish

   !> Whether x is neither NaN nor infinite. The bits are asked, as comparing a NaN may trap.
   elemental function is_finite(x) result(yes)
      real(real64), intent(in) :: x  !! any value
      logical :: yes
      yes = iand(transfer(x, 0_int64), huge(0_int64)) < infinity_bits
   end function is_finite

end module funit
