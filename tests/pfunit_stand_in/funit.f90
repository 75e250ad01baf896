!> Stand-in for pFUnit where it is not installed: the procedures that a translated .pf suite calls. It is never less
!> strict than pFUnit 4.14.
module funit
   use, intrinsic :: iso_fortran_env, only: output_unit, real32, real64
   use pf_operands, only: element_text, is_finite, is_nan, list_text, operand_type, pf_value, trimmed
   implicit none
   private

   public :: pf_value, pf_assert, pf_assert_raised, pf_raised, pf_run, pf_finish, throw, output_unit

   ! What pFUnit 4.14 exports as well: with either, a suite that means an intrinsic procedure by one of these names, or
   ! declares it in its module, is not compiled.
   integer, parameter, public :: &
      abstractmatcher=0, abstracttestparameter=0, all_of=0, allof=0, any_of=0, anyexceptions=0, anyof=0, &
      array_with_size=0, assert_that=0, assertall=0, assertany=0, assertequal=0, assertexceptionraised=0, &
      assertfail=0, assertfalse=0, assertgreaterthan=0, assertgreaterthanorequal=0, assertisfinite=0, assertisnan=0, &
      assertlessthan=0, assertlessthanorequal=0, assertnone=0, assertnotall=0, assertnotequal=0, &
      assertrelativelyequal=0, assertsameshape=0, asserttrue=0, basetestrunner=0, catch=0, catchnext=0, &
      contains_string=0, debuglistener=0, disable=0, empty_array=0, ends_with=0, equal_to=0, every=0, every_item=0, &
      expectation=0, false=0, finalize=0, generic_run=0, get_context=0, ignore_all=0, ignore_differences=0, &
      initialize=0, is=0, isarraywithsize=0, isequal=0, isnear=0, isnot=0, isrelativelynear=0, istrueorfalse=0, &
      keep_all=0, listenerpointer=0, loadtests_interface=0, matchable=0, matcherdescription=0, namefilter=0, near=0, &
      not=0, parallelcontext=0, parameterizedtestcase=0, predicate=0, relatively_near=0, resultprinter=0, run=0, &
      serialcontext=0, sourcelocation=0, starts_with=0, stringcontains=0, stringdescription=0, stringendswith=0, &
      stringstartswith=0, stub=0, subject=0, taplistener=0, test=0, testannotation=0, testcase=0, testlistener=0, &
      testlistenervector=0, testmethod=0, testresult=0, testrunner=0, testsuite=0, timeoutannotation=0, trim_all=0, &
      true=0, wascalled=0, wascalledonce=0, wasnotcalled=0, whitespaceoptions=0, xmlprinter=0

   abstract interface
      !> A test, a @before or an @after.
      subroutine suite_procedure()
         implicit none
      end subroutine suite_procedure
   end interface

   integer, parameter :: max_pending = 20  ! largest number of failures of one test that are reported in full
   character(len=*), parameter :: next_line = new_line("a")//"      "

   integer :: pending = 0                  ! failures of the running test that no assertion has caught
   character(len=2000) :: message_of(max_pending) = ""
   character(len=200) :: place_of(max_pending) = ""
   integer :: passed = 0, failed = 0

contains

   !> Whether op holds for one pair of elements. A NaN fails every assertion except IsNaN.
   pure function compare(op, e, a, tolerance, single) result(holds)
      character(len=*), intent(in) :: op     !! name of the assertion
      real(real64), intent(in) :: e          !! expected, or left-hand side
      real(real64), intent(in) :: a          !! actual, or right-hand side
      real(real64), intent(in) :: tolerance  !! finite, not negative
      logical, intent(in) :: single          !! round as real32 arithmetic would
      logical :: holds, finite, same
      real(real64) :: l, r, t, scaling

      holds = op == "IsNaN" .and. is_nan(a)
      if (op == "IsNaN" .or. is_nan(e) .or. is_nan(a)) return
      ! No operation below overflows, so there is no floating-point trap.
      scaling = merge(0.25_real64, 1.0_real64, max(abs(e), abs(a), tolerance) > 0.25_real64*huge(a))
      l = scaling*e
      r = scaling*a
      t = scaling*tolerance
      finite = is_finite(e) .and. is_finite(a)
      same = .not. (l < r .or. l > r)
      select case (op)
      case ("True")
         holds = a > 0.5_real64
      case ("False")
         holds = a < 0.5_real64
      case ("IsFinite")
         holds = finite
      case ("Equal")
         holds = same
         if (finite) holds = abs(rounded(r - l, single)) <= t
      case ("NotEqual")
         if (.not. same) holds = abs(rounded(r - l, single)) > t
      case ("LessThan")
         holds = l < rounded(r + t, single)
      case ("LessThanOrEqual")
         holds = l <= rounded(r + t, single)
      case ("GreaterThan")
         holds = l > rounded(r - t, single)
      case ("GreaterThanOrEqual")
         holds = l >= rounded(r - t, single)
      case ("RelativelyEqual")
         if (finite .and. abs(l) > 0) holds = abs(rounded(r - l, single)) <= rounded(tolerance*abs(l), single)
      case default
      end select
   end function compare

   !> Reason why the operands do not fit the assertion (kind, rank, shape, tolerance). The result is empty if they fit.
   pure function misfit(op, a, e, t) result(why)
      character(len=*), intent(in) :: op             !! name of the assertion
      type(operand_type), intent(in) :: a            !! actual, or right-hand side
      type(operand_type), intent(in), optional :: e  !! expected, or left-hand side
      type(operand_type), intent(in), optional :: t  !! tolerance
      character(len=:), allocatable :: why
      character(len=40) :: kinds
      integer :: max_rank

      max_rank = 2
      kinds = "real64 real32"
      select case (op)
      case ("True", "False")
         kinds = "logical"
         max_rank = 1
      case ("IsNaN", "IsFinite")
         max_rank = 0
      case ("Equal")
         kinds = "real64 real32 integer logical character"
      case ("NotEqual")
         kinds = "real64 real32 integer logical"
      case ("LessThan", "LessThanOrEqual", "GreaterThan", "GreaterThanOrEqual")
         kinds = "real64 real32 integer"
      case default
      end select
      why = ""
      if (index(kinds, trim(a%kind)) == 0) then
         why = "operands must be "//trim(kinds)//", not "//a%kind
      else if (size(a%extents) > max_rank) then
         why = "rank must not exceed "//list_text([max_rank])
      end if
      if (present(e) .and. why == "") then
         if (e%kind /= a%kind) then
            why = "kinds differ: "//trim(e%kind)//" and "//a%kind
         else if (all(size(e%extents) /= [0, size(a%extents)])) then
            why = "ranks do not fit: "//list_text([size(e%extents)])//" and "//list_text([size(a%extents)])
         else if (any(e%extents /= a%extents(:size(e%extents)))) then
            why = "shapes differ: "//list_text(e%extents)//" and "//list_text(a%extents)
         end if
      end if
      if (present(t) .and. why == "") then
         if (a%kind(:4) /= "real" .or. t%kind /= a%kind .or. size(t%extents) > 0) then
            why = "tolerance must be a scalar of the same kind as the operands, real64 or real32"
         else if (.not. is_finite(t%v(1))) then
            why = "tolerance must be finite"
         else if (t%v(1) < 0 .or. (op == "RelativelyEqual" .and. t%v(1) > 1)) then
            why = "tolerance must not be negative, nor a relative one beyond 1"
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
         why = text_difference(expected%text, actual%text)
         if (why == "") return
      else if (why == "") then
         t = 0.0_real64
         if (present(tolerance)) t = tolerance%v(1)
         e = actual%v
         if (present(expected)) e = reshape(expected%v, shape(e), pad=expected%v)
         do i = 1, size(e)
            if (.not. compare(op, e(i), actual%v(i), t, actual%kind == "real32")) exit
         end do
         if (i > size(e)) return
         if (present(expected)) why = "expected "//element_text(e(i), actual%kind)//next_line
         why = why//"actual   "//element_text(actual%v(i), actual%kind)
         if (present(tolerance)) why = why//next_line//"within   "//element_text(t, actual%kind)
         if (size(actual%extents) > 0) why = why//next_line//"element  "//list_text([i])//" of shape "// &
            list_text(actual%extents)
      end if
      if (present(message)) why = why//next_line//"message  "//message
      call raise("@assert"//op//next_line//why, file//":"//list_text([line]))
   end subroutine pf_assert

   !> Expected and actual text if they differ, not counting blanks and tabs at the ends. Otherwise the result is empty.
   pure function text_difference(expected, actual) result(why)
      character(len=*), intent(in) :: expected  !! any text
      character(len=*), intent(in) :: actual    !! any text
      character(len=:), allocatable :: why, e, a

      e = trimmed(expected)
      a = trimmed(actual)
      why = ""
      if (e /= a) why = "expected <"//e//">"//next_line//"actual   <"//a//">"
   end function text_difference

   !> Assert that a failure was thrown (with that text), and remove it.
   subroutine pf_assert_raised(file, line, message)
      character(len=*), intent(in) :: file               !! name of the .pf file
      integer, intent(in) :: line                        !! line of the directive
      character(len=*), intent(in), optional :: message  !! text thrown; absent: the last one, whatever its text
      integer :: i

      do i = min(pending, max_pending), 1, -1
         if (.not. present(message)) exit
         if (message_of(i) == message) exit
      end do
      if (i == 0) then
         call raise("@assertExceptionRaised"//next_line//"it was not thrown", file//":"//list_text([line]))
      else
         message_of(i:max_pending - 1) = message_of(i + 1:)
         place_of(i:max_pending - 1) = place_of(i + 1:)
         pending = pending - 1
      end if
   end subroutine pf_assert_raised

   !> Make the running test fail.
   subroutine throw(message)
      character(len=*), intent(in) :: message  !! text reported with the failure
      call raise(message, "thrown")
   end subroutine throw

   !> Store a failure of the running test and its place.
   subroutine raise(message, place)
      character(len=*), intent(in) :: message  !! text reported with the failure
      character(len=*), intent(in) :: place    !! file:line
      pending = pending + 1
      if (pending > max_pending) return
      message_of(pending) = message
      place_of(pending) = place
   end subroutine raise

   !> Whether the running test has failed.
   function pf_raised() result(raised)
      logical :: raised
      raised = pending > 0
   end function pf_raised

   !> Run, report and count one test.
   subroutine pf_run(suite, name, test, before, after)
      character(len=*), intent(in) :: suite             !! module of the suite
      character(len=*), intent(in) :: name              !! name of the test
      procedure(suite_procedure) :: test                !! the test
      procedure(suite_procedure), optional :: before    !! set-up; if it fails, test and clean-up are not run
      procedure(suite_procedure), optional :: after     !! clean-up, also of a test that failed
      integer :: i

      write (output_unit, "(a)", advance="no") suite//" "//name//" ... "
      flush (output_unit)
      pending = 0
      if (present(before)) call before()
      if (pending == 0) then
         call test()
         if (present(after)) call after()
      end if
      passed = passed + merge(1, 0, pending == 0)
      failed = failed + merge(1, 0, pending > 0)
      write (output_unit, "(a)") trim(merge("ok    ", "FAILED", pending == 0))
      do i = 1, min(pending, max_pending)
         write (output_unit, "(a)") "   "//trim(place_of(i))//": "//trim(message_of(i))
      end do
      if (pending > max_pending) write (output_unit, "(a)") "   and "//list_text([pending - max_pending])//" more"
   end subroutine pf_run

   !> Print the closing line. The program stops with exit status 1 if a test failed or no test ran.
   subroutine pf_finish()
      write (output_unit, "(a)") list_text([passed])//" passed, "//list_text([failed])//" failed"
      flush (output_unit)
      if (failed > 0 .or. passed == 0) stop 1
   end subroutine pf_finish

   !> The value x, or the result of real32 arithmetic for it. The result is exact, because real64 has more than twice
   !> the digits of real32.
   elemental function rounded(x, single) result(y)
      real(real64), intent(in) :: x  !! result of one operation in real64
      logical, intent(in) :: single  !! round to real32
      real(real64) :: y
      y = x
      if (single .and. abs(x) <= real(huge(0.0_real32), real64)) y = real(real(x, real32), real64)
   end function rounded

end module funit
