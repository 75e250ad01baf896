!> Fuzz test of the C API: calls with random arrays of points, where one argument may be invalid.
module fuzz_c
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64
  use asperity_c, only: asperity_nstatv, asperity_update
  use asperity_call_checks, only: state_status
  use asperity_checks, only: all_bounded
  use asperity_text, only: append, integer_text, to_text
  use asperity_contract, only: status_ok
  use asperity_interface, only: interface_type, new_interface, separation_bound
  use asperity_kinds, only: wp
  use fuzz_draw, only: any_value, draw_props, most_props
  use random_numbers, only: chance, log_uniform, pick, seed_of, uniform
  implicit none
  private
  public :: try_c

  integer, parameter :: most_points = 200, most_message = 300
  !> Character after the end of a message buffer, which must not change.
  character(kind=c_char), parameter :: fence = "#"

contains

  !> Run one case; `complaint` is set if something is wrong.
  subroutine try_c(seed, number, calls, rejected, complaint, inputs)
    integer(int64), intent(in) :: seed, number                  !! of the run, of the case
    integer, intent(out) :: calls                               !! of asperity_update
    logical, intent(out) :: rejected                            !! whether the last call was
    character(len=:), allocatable, intent(inout) :: complaint   !! set if something is wrong
    character(len=:), allocatable, intent(inout) :: inputs      !! of the last call, if something is wrong
    integer(int64) :: stream
    type(interface_type) :: joint
    real(wp), target :: props(most_props)
    real(wp) :: dt, scale
    real(wp), allocatable :: before(:, :)
    real(wp), allocatable, target :: s(:, :), state(:, :), traction(:, :), s_old(:, :), tangent(:, :, :)
    character(kind=c_char), target :: message(most_message + 1)
    type(c_ptr) :: from, slope, text
    integer(c_int) :: length, n, nprops, nstatv, status
    integer :: i, increment, increments, j
    logical :: spoil

    complaint = ""
    inputs = ""
    calls = 1
    rejected = .false.
    stream = seed_of(seed, number)
    call draw_props(stream, props, i)
    nprops = int(i, c_int)
    call new_interface(props(:nprops), joint, i)
    n = int(pick(stream, merge(most_points, 4, mod(number, 4_int64) == 0_int64)) - 1, c_int)
    nstatv = asperity_nstatv(c_loc(props), nprops, c_null_ptr, 0_c_int)
    if (nstatv /= joint%n_statev) call append(complaint, "asperity_nstatv = " // integer_text(int(nstatv)))
    if (chance(stream, 0.1_wp)) nstatv = nstatv + 1_c_int
    allocate (s(3, n), s_old(3, n), state(nstatv, n), before(nstatv, n), traction(3, n), tangent(3, 3, n))
    s_old = 0.0_wp
    state = 0.0_wp
    scale = log_uniform(stream, -2.0_wp, 3.0_wp)
    scale = scale*separation_bound(joint)*1.0e-50_wp
    increments = pick(stream, 3)
    spoil = chance(stream, 0.4_wp)
    do increment = 1, increments
      do i = 1, n
        do j = 1, 3
          s(j, i) = scale*(uniform(stream) - 0.5_wp)
        end do
      end do
      dt = log_uniform(stream, -6.0_wp, 6.0_wp)
      if (spoil .and. increment == increments) call spoil_input()
      before = state
      traction = 7.0_wp
      call choose(c_loc(s_old), from)
      call choose(c_loc(tangent), slope)
      call choose(c_loc(message), text)
      length = int(pick(stream, most_message), c_int)
      message = fence
      calls = increment
      status = asperity_update(c_loc(props), nprops, dt, n, from, c_loc(s), nstatv, c_loc(state), c_loc(traction), &
        slope, text, length)
      call judge()
      if (rejected .or. len(complaint) > 0) exit
      s_old = s
    end do
    if (len(complaint) > 0) call describe()

  contains

    !> A pointer, or NULL in one of four cases.
    subroutine choose(given, chosen)
      type(c_ptr), intent(in) :: given    !! pointer
      type(c_ptr), intent(out) :: chosen  !! the same pointer, or NULL
      chosen = given
      if (pick(stream, 4) == 1) chosen = c_null_ptr
    end subroutine choose

    !> Replace one of the arguments by an arbitrary value.
    subroutine spoil_input()
      integer :: p, where_to
      where_to = pick(stream, 6)
      if (n < 1) where_to = 1
      p = pick(stream, max(1, int(n)))
      select case (where_to)
      case (1)
        i = pick(stream, int(nprops))
        props(i) = any_value(stream)
      case (2)
        i = pick(stream, 3)
        s(i, p) = any_value(stream)
      case (3)
        i = pick(stream, int(nstatv))
        state(i, p) = any_value(stream)
      case (4)
        dt = any_value(stream)
      case (5)
        i = pick(stream, 2)
        nprops = merge(nprops - 1_c_int, -nprops, i == 1)
      case default
        if (p > n/2) then
          n = -n
        else
          i = pick(stream, 2)
          nstatv = merge(nstatv - 1_c_int, -nstatv, i == 1)
          deallocate (state, before)
          allocate (state(max(0, int(nstatv)), n), before(max(0, int(nstatv)), n))
          state = 0.0_wp
        end if
      end select
    end subroutine spoil_input

    !> Check that the call was accepted with finite results, or rejected without output.
    subroutine judge()
      rejected = status /= status_ok
      if (.not. all(message(length + 1:) == fence)) call append(complaint, "a message beyond its buffer")
      if (rejected) then
        if (.not. all(transfer(state, [0_int64]) == transfer(before, [0_int64]))) call append(complaint, &
          "a rejected call wrote the state")
        if (any(abs(traction - 7.0_wp) > 0.0_wp)) call append(complaint, "a rejected call wrote the traction")
        if (.not. spoil) call append(complaint, &
          "admissible input was rejected with status " // integer_text(int(status)))
        call check_message()
      else
        if (n < 1) return
        if (.not. all_bounded(size(traction), traction, huge(1.0_wp))) call append(complaint, &
          "a traction is not finite")
        call new_interface(props(:nprops), joint, i)
        do i = 1, n
          if (state_status(joint, state(:, i)) == status_ok) cycle
          call append(complaint, "its own state would be rejected")
          exit
        end do
      end if
    end subroutine judge

    !> Check that every rejection has a message, cut to the buffer and ended by a zero.
    subroutine check_message()
      call choose(c_loc(message), text)
      message = fence
      status = asperity_update(c_loc(props), nprops, dt, n, from, c_loc(s), nstatv, c_loc(state), c_loc(traction), &
        slope, c_loc(message), int(most_message, c_int))
      do i = 1, most_message
        if (message(i) == c_null_char) exit
      end do
      if (i > most_message) then
        call append(complaint, "a message that is not closed")
      else if (i < 10) then
        call append(complaint, "a message of " // integer_text(i - 1) // " characters")
      end if
    end subroutine check_message

    !> Text of the last call.
    subroutine describe()
      call append(inputs, "increment " // integer_text(increment) // ", n " // integer_text(int(n)) // ", nstatv " // &
        integer_text(int(nstatv)) // ", dt " // to_text(dt))
      do i = 1, nprops
        call append(inputs, "props[" // integer_text(i - 1) // "] " // to_text(props(i)))
      end do
    end subroutine describe

  end subroutine try_c

end module fuzz_c
