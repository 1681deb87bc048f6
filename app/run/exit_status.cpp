#include "app/run/exit_status.h"

#include <cstring>
#include <exception>
#include <new>
#include <string>

#include "app/run/output.h"
#include "app/run/output_error.h"

namespace skein::app {
namespace {

/// On a busy machine the last words may take longer than what is said beside a tick; a reader may never come. [s]
constexpr double last_patience = 3.0;

int status_of(const std::function<int()>& program) noexcept {
  try {
    const int status = program();
    finish_output(last_patience);
    const int error = output_error();
    if (error == 0) return status;
    complain(std::string("stdout: cannot be written: ") + std::strerror(error));
    return status == done ? static_cast<int>(device_failed) : status;
  } catch (const std::bad_alloc&) {
    complain("out of memory");
  } catch (const std::exception& error) {
    complain(error.what());
  } catch (...) {
    complain("an unknown error");
  }
  return device_failed;
}

}  // namespace

int exit_status_of(const std::function<int()>& program) noexcept {
  fill_standard_descriptors();
  const int status = status_of(program);
  finish_output(last_patience);
  return status;
}

}  // namespace skein::app
