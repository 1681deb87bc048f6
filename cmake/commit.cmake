# cmake -DSOURCE=... -DHEADER=... -P commit.cmake: writes a header that defines SKEIN_COMMIT, anew only where it changes.
# In a checkout git knows the commit; in an archive that git made, git has written it here.
cmake_minimum_required(VERSION 3.25)
set(commit "$Format:%h$")
if(commit MATCHES "Format")
  execute_process(COMMAND git -C ${SOURCE} describe --always --exclude=* --abbrev=12 --dirty=+changes
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT "#define SKEIN_COMMIT \"@commit@\"\n" @ONLY)
