!> Output of the times as a printed table and as CSV.
module table
  use, intrinsic :: iso_fortran_env, only: real64
  use asperity_instruction_set, only: instruction_set
  use tasks, only: row_type
  implicit none
  private
  public :: add_limits, find, print_table, write_csv

contains

  !> The row with these properties; the program stops if there is none.
  function find(rows, pattern, kernel, precision, tangent, states, points, threads) result(row)
    type(row_type), intent(in) :: rows(:)       !! where to look
    character(len=*), intent(in) :: pattern     !! its pattern
    character(len=*), intent(in) :: kernel      !! its kernel
    character(len=*), intent(in) :: precision   !! double or single
    logical, intent(in) :: tangent              !! whether the kernel computes the tangent
    character(len=*), intent(in) :: states      !! its states at the start
    integer, intent(in), optional :: points     !! its number of points, absent: any
    integer, intent(in), optional :: threads    !! its number of threads, absent: 1
    type(row_type) :: row
    integer :: i, n_points, n_threads
    n_threads = 1
    if (present(threads)) n_threads = threads
    do i = 1, size(rows)
      row = rows(i)
      n_points = row%points
      if (present(points)) n_points = points
      if (row%threads /= n_threads .or. row%points /= n_points) cycle
      if (row%pattern == pattern .and. row%kernel == kernel .and. row%precision == precision &
          .and. (row%tangent .eqv. tangent) .and. row%states == states) return
    end do
    error stop "bench: no such row"
  end function find

  !> Set the times with which a row is compared: textbook version and hardware limits of the same run.
  pure subroutine add_limits(rows)
    type(row_type), intent(inout) :: rows(:)   !! all rows
    integer :: i, j
    do i = 1, size(rows)
      do j = 1, size(rows)
        if (rows(i)%pattern /= rows(j)%pattern) cycle
        if (rows(j)%kernel == "textbook" .and. (rows(i)%tangent .eqv. rows(j)%tangent) &
            .and. rows(i)%kernel /= "test" .and. .not. limit(rows(i))) rows(i)%textbook = rows(j)%ns
        if (limit(rows(i)) .or. rows(i)%precision /= rows(j)%precision) cycle
        if (rows(j)%kernel == "roots" .and. rows(i)%kernel /= "test") rows(i)%roots = rows(j)%ns
        if (rows(j)%kernel == "stream" .and. rows(i)%kernel == "vumat") rows(i)%stream = rows(j)%ns
        if (rows(j)%kernel == "copy" .and. rows(i)%kernel == "points" .and. rows(i)%points == rows(j)%points &
            .and. rows(i)%threads == rows(j)%threads) rows(i)%stream = rows(j)%ns
      end do
    end do
  end subroutine add_limits

  !> Whether the row is a hardware limit.
  pure function limit(row) result(yes)
    type(row_type), intent(in) :: row   !! any row
    logical :: yes
    yes = row%kernel == "stream" .or. row%kernel == "roots" .or. row%kernel == "copy"
  end function limit

  !> Print the table.
  subroutine print_table(rows)
    type(row_type), intent(in) :: rows(:)   !! what to print
    integer :: i
    print "(2a)", "pattern  planes kernel     precision tangent states      points threads  ns/point  ns/plane", &
      "  textbook/ns  ns/streaming  ns/roots"
    do i = 1, size(rows)
      print "(a8, i7, 1x, a10, 1x, a9, 1x, a7, 1x, a9, i9, i8, f10.2, f10.3, a13, a14, a10)", rows(i)%pattern, &
        rows(i)%planes, rows(i)%kernel, rows(i)%precision, yes_no(rows(i)), rows(i)%states, rows(i)%points, &
        rows(i)%threads, rows(i)%ns, &
        rows(i)%ns/real(rows(i)%planes, real64), ratio(rows(i)%textbook, rows(i)%ns), &
        ratio(rows(i)%ns, rows(i)%stream), ratio(rows(i)%ns, rows(i)%roots)
    end do
  end subroutine print_table

  !> Write the table as CSV.
  subroutine write_csv(unit, rows)
    integer, intent(in) :: unit             !! open for writing
    type(row_type), intent(in) :: rows(:)   !! all rows
    integer :: i
    write (unit, "(2a)") "pattern,planes,kernel,precision,tangent,states,points,threads,ns_per_point,ns_per_plane,", &
      "textbook_ratio,stream_ratio,roots_ratio,isa"
    do i = 1, size(rows)
      write (unit, "(a, ',', i0, 4(',', a), 2(',', i0), 2(',', f0.4), 3(',', a), ',', i0)") trim(rows(i)%pattern), &
        rows(i)%planes, trim(rows(i)%kernel), trim(rows(i)%precision), trim(yes_no(rows(i))), trim(rows(i)%states), &
        rows(i)%points, rows(i)%threads, rows(i)%ns, rows(i)%ns/real(rows(i)%planes, real64), &
        trim(adjustl(ratio(rows(i)%textbook, rows(i)%ns))), &
        trim(adjustl(ratio(rows(i)%ns, rows(i)%stream))), trim(adjustl(ratio(rows(i)%ns, rows(i)%roots))), &
        instruction_set()
    end do
  end subroutine write_csv

  !> Whether the row has a tangent.
  pure function yes_no(row) result(text)
    type(row_type), intent(in) :: row   !! any row
    character(len=3) :: text
    text = merge("yes", "no ", row%tangent)
  end function yes_no

  !> a/b as a text, empty where one of them is missing.
  pure function ratio(a, b) result(text)
    real(real64), intent(in) :: a   !! ns, 0: none
    real(real64), intent(in) :: b   !! ns, 0: none
    character(len=10) :: text
    text = ""
    if (a > 0.0_real64 .and. b > 0.0_real64) write (text, "(f10.3)") a/b
  end function ratio

end module table
