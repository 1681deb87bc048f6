// Empty: its target precompiles headers for the others (skein.cmake).
