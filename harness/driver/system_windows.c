/* Files of Windows, where a file has no inode and text mode would change the ends of lines. */
#include "system_files.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <process.h>
#include <share.h>
#include <windows.h>

void system_prepare(void) { _setmode(1, _O_BINARY); }

int system_create(const char *path) {
  const int file = _sopen(path, _O_WRONLY | _O_CREAT | _O_BINARY, _SH_DENYWR, 0666);
  /* a file that may not be written at all gives the same errno */
  if (file < 0 && errno == EACCES && _access(path, 2) == 0) return SYSTEM_LOCKED;
  return file;
}

int system_open(const char *path) { return _open(path, _O_RDONLY | _O_BINARY); }

void system_hold_signals(bool hold) { (void)hold; }

static void wait_for_end(void *unused) {
  char bytes[256];
  int got = 1;
  (void)unused;
  while (got > 0) got = _read(0, bytes, sizeof bytes);
  if (got == 0) _exit(1);
}

int system_end_with_input(void) { return _beginthread(wait_for_end, 0, NULL) == (uintptr_t)-1 ? errno : 0; }

static bool identify(const char *path, BY_HANDLE_FILE_INFORMATION *found) {
  const HANDLE handle = CreateFileA(path, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
                                    OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, NULL);
  if (handle == INVALID_HANDLE_VALUE) return false;
  const bool good = GetFileInformationByHandle(handle, found);
  CloseHandle(handle);
  return good;
}

bool system_same_file(const char *first, const char *second) {
  BY_HANDLE_FILE_INFORMATION a, b;
  return identify(first, &a) && identify(second, &b) && a.dwVolumeSerialNumber == b.dwVolumeSerialNumber &&
         a.nFileIndexHigh == b.nFileIndexHigh && a.nFileIndexLow == b.nFileIndexLow;
}
