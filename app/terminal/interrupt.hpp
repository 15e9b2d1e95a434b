#pragma once

namespace ceilmap::terminal {

/// Ctrl-C (SIGINT) and SIGTERM: the first asks the running command to finish early and keep what is
/// done, the second ends the program at once with exit code 130. Loops over frames poll
/// Interrupted().

void InstallInterruptHandler();
bool Interrupted();

/// What the handler does for the first signal, and its opposite; for tests.
void RequestInterrupt();
void ClearInterrupt();

}  // namespace ceilmap::terminal
