#pragma once

#include <string>
#include <string_view>

/// Where the tests find what they start and read. One source file knows the places, so that no other object depends on
/// the folder of the checkout and the compiler cache serves every checkout.
namespace skein::test {

/// The absolute path of `path`, which is relative to the root of the checkout.
std::string in_source(std::string_view path);
/// The absolute path of the program `skein` that was built beside the tests.
std::string program();
/// The absolute path of the program that dies on purpose (tests/app/victim.cpp).
std::string victim();
/// The absolute path of a camera in software (tests/vision/aravis/fake_gige.cpp).
std::string fake_gige();

}  // namespace skein::test
