!> Paths of POSIX systems.
module asperity_separators
  implicit none
  private
  !> Characters between folders; whether a path may begin with a drive, as C:.
  character(len=*), parameter, public :: separators = "/"
  logical, parameter, public :: has_drives = .false.
end module asperity_separators
