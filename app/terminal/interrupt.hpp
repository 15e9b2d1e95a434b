#pragma once

namespace ceilmap::terminal {

/// Ctrl-C (SIGINT) and SIGTERM: the first signal requests the command to finish early and keep its
/// results, the second one ends the program at once with exit code 130. Loops over frames poll
/// Interrupted().

void InstallInterruptHandler();
bool Interrupted();

/// Sets the state of the first signal, and clears it; for tests.
void RequestInterrupt();
void ClearInterrupt();

}  // namespace ceilmap::terminal
