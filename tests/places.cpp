#include "tests/places.h"

namespace skein::test {

std::string in_source(std::string_view path) {
  return std::string(SKEIN_SOURCE_DIR "/").append(path);
}

std::string program() {
  return SKEIN_PROGRAM_FOLDER "/skein";
}

std::string victim() {
  return SKEIN_PROGRAM_FOLDER "/skein_victim";
}
std::string fake_gige() {
  return SKEIN_PROGRAM_FOLDER "/skein_fake_gige";
}

}  // namespace skein::test
