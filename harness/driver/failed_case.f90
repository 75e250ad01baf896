!> Case file that repeats a failed increment: material, pattern, state at its start, prescribed values at its end.
module failed_case
  use asperity_case_umat, only: default_limit, umat_type
  use asperity_text, only: integer_text, to_text
  use asperity_contract, only: n_fixed_props, n_listed_values, n_required_props, p_m, p_tau_v, prop_table
  use asperity_kinds, only: wp
  use asperity_load_path, only: run_type
  use asperity_steps, only: component_names
  use asperity_case_material, only: in_group
  use row_file, only: close_file, create_file, write_line
  implicit none
  private
  public :: write_failed_case

  !> Start of every such file.
  character(len=*), parameter, public :: failed_title = "&case title = 'failed increment "

contains

  !> Write the file; numbers read back exactly.
  subroutine write_failed_case(path, props, umat, run, written)
    character(len=*), intent(in) :: path       !! file, replaced if it exists
    real(wp), intent(in) :: props(:)           !! PROPS
    type(umat_type), intent(in) :: umat        !! the law instead, if it is given
    type(run_type), intent(in) :: run          !! a run, after this increment
    logical, intent(out) :: written            !! false: the reason is on standard error
    character(len=:), allocatable :: text
    integer :: fd, i, k

    call create_file(path, fd, written)
    if (.not. written) return
    call write_line(fd, path, failed_title // integer_text(run%law%increment) // &
      " of step " // integer_text(run%law%step) // "' /", written)
    if (umat%given) then
      text = "&umat library = " // quoted(umat%library) // ", symbol = '" // umat%symbol // "', nstatv = " // &
        integer_text(umat%nstatv) // "," // new_line("a") // " "
      if (size(umat%props) > 0) text = text // entry("props", umat%props)
      text = text // entry("length", [umat%length]) // entry("stiffness", [umat%stiffness]) // &
        entry("thickness", [umat%thickness]) // " order = '" // umat%order // "'"
      if (abs(umat%limit - default_limit) > 0.0_wp) text = text // entry("limit", [umat%limit])
      if (umat%damage > 0) text = text // " damage = " // integer_text(umat%damage)
      if (written) call write_line(fd, path, text // " /", written)
    else
      if (written) call write_line(fd, path, "&material" // entries("material") // " /", written)
      if (props(p_m) < 0.0_wp) then
        text = ""
        k = nint(-props(p_m))
        associate (planes => reshape(props(n_fixed_props + 1:n_fixed_props + n_listed_values*k), [n_listed_values, k]))
          text = entry("normals", reshape(planes(1:3, :), [3*k])) // entry("weights", planes(4, :))
        end associate
      else
        text = entry("sides", props(p_m:p_m)) // entries("pattern")
      end if
      if (written) call write_line(fd, path, "&pattern" // text // " /", written)
    end if
    if (written) call write_line(fd, path, "&state" // entry("separation", run%before%s) // &
      entry("statev", run%before%state) // entry("work", [run%before%work]) // " /", written)
    text = ""
    do i = 1, 3
      if (run%control%traction(i)) then
        ! the force of a spring is zero at the start of the step
        text = text // entry("t_" // trim(component_names(i)), &
          [run%given(i) - run%control%spring(i)*run%before%s(i)])
        if (run%control%spring(i) > 0.0_wp) text = text // entry("k_" // trim(component_names(i)), &
          run%control%spring(i:i))
      else
        text = text // entry("s_" // trim(component_names(i)), run%given(i:i))
      end if
    end do
    if (props(p_tau_v) > 0.0_wp .or. umat%given) text = text // entry("time", [run%control%dt])
    if (run%steps(run%law%step)%arc > 0.0_wp) then
      text = text // " follow = 'branch'" // entry("arc", [run%steps(run%law%step)%arc])
    else
      text = text // " increments = 1"
    end if
    if (written) call write_line(fd, path, "&step" // text // " /", written)
    call close_file(fd, path, written)

  contains

    !> A string of a case file; a doubled quote stands for one.
    pure function quoted(string) result(piece)
      character(len=*), intent(in) :: string   !! any
      character(len=:), allocatable :: piece
      integer :: j
      piece = "'"
      do j = 1, len(string)
        piece = piece // string(j:j)
        if (string(j:j) == "'") piece = piece // "'"
      end do
      piece = piece // "'"
    end function quoted

    !> The constants of a group that differ from their default.
    pure function entries(group) result(list)
      character(len=*), intent(in) :: group   !! name of the group
      character(len=:), allocatable :: list
      integer :: j
      list = ""
      do j = 1, n_fixed_props
        if (.not. in_group(j, group)) cycle
        if (j <= n_required_props .or. abs(props(j) - prop_table(j)%default) > 0.0_wp) list = list // &
          entry(trim(prop_table(j)%name), props(j:j))
      end do
    end function entries

    !> An entry of a group: a name and its values.
    pure function entry(name, values) result(piece)
      character(len=*), intent(in) :: name   !! of the entry
      real(wp), intent(in) :: values(:)      !! any
      character(len=:), allocatable :: piece
      !> Values on a line.
      integer, parameter :: width = 3
      integer :: j
      piece = " " // name // " ="
      do j = 1, size(values)
        if (j > 1) piece = piece // ","
        if (modulo(j, width) == 1 .and. j > 1) piece = piece // new_line("a") // " "
        piece = piece // " " // to_text(values(j))
      end do
    end function entry

  end subroutine write_failed_case

end module failed_case
