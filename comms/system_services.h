#pragma once

#include <sys/types.h>

#include <string>

#include "comms/inhibitor.h"

/// What a run with robots asks of the machine's own services, over D-Bus. A service that does not answer is waited for
/// for at most 2 s a call.
namespace skein::comms {

/// The machine stays awake (systemd's logind, inhibitors "sleep" and "handle-lid-switch"): robots have no watchdog, and
/// a suspended machine cannot stop them.
Inhibitor::Answer inhibit_sleep(const std::string& what);

/// The desktop neither blanks nor locks its screen for want of keys (org.freedesktop.ScreenSaver, which GNOME, KDE,
/// Xfce and others offer): who watches robots touches no key, and cannot stop them behind a locked screen.
Inhibitor::Answer inhibit_screen_lock(const std::string& what);

/// Moves a process of this user into a unit of its own, NAME-PROCESS.scope, of the service manager (systemd): the
/// user's, or for root the system's. systemd-oomd, and whatever else ends a whole control group, then ends the program
/// without it. False: there is no service manager, or it refuses.
bool move_to_own_scope(pid_t process, const char* name, const char* description);

}  // namespace skein::comms
