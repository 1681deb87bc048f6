#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <string>

namespace skein::vision {

/// A file that a lab shares stays one, and a private one private: a draft, an open descriptor, gets owner, group and
/// mode of the file that it will replace, as far as this user may give them. Nothing happens where there is none. Here,
/// since films need it as well as all files of app.
inline void keep_rights(const std::string& replaced, int draft) noexcept {
  struct stat there {};
  if (::stat(replaced.c_str(), &there) != 0 || !S_ISREG(there.st_mode)) return;
  mode_t mode = there.st_mode & 07777;
  if (::fchown(draft, there.st_uid, there.st_gid) != 0 && ::fchown(draft, static_cast<uid_t>(-1), there.st_gid) != 0)
    mode &= ~static_cast<mode_t>(S_IRWXG);  // of another group
  ::fchmod(draft, mode);
}

}  // namespace skein::vision
