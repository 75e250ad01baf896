!> Paths of Windows.
module asperity_separators
  implicit none
  private
  !> Characters between folders; whether a path may begin with a drive, as C:.
  character(len=*), parameter, public :: separators = "/\"
  logical, parameter, public :: has_drives = .true.
end module asperity_separators
