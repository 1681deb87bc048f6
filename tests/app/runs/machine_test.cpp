#include "app/runs/machine.h"

#include <gtest/gtest.h>

namespace skein::app {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view cortex = R"(processor	: 0
BogoMIPS	: 108.00
Features	: fp asimd evtstrm crc32 cpuid
CPU implementer	: 0x41
CPU architecture: 8
CPU variant	: 0x4
CPU part	: 0xd0b
CPU revision	: 1

)";

TEST(Machine, AProcessorIsNamedAsTheKernelNamesIt) {
  EXPECT_EQ(cpu_name("processor\t: 0\nmodel name\t: Some Processor @ 2.8 GHz\nflags\t: fpu\n", "a computer\0"sv),
            "Some Processor @ 2.8 GHz");
}

TEST(Machine, OnArmTheComputerIsNamed) {
  EXPECT_EQ(cpu_name(cortex, "Raspberry Pi 5 Model B Rev 1.0\0"sv), "Raspberry Pi 5 Model B Rev 1.0");
  EXPECT_EQ(cpu_name(cortex, ""), "ARM, implementer 0x41, part 0xd0b");
  EXPECT_EQ(cpu_name("", ""), "");
}

}  // namespace
}  // namespace skein::app
