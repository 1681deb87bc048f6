#include "app/experiment/toml_edit.h"

#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

TEST(TomlEdit, ChangesOneValueAndNothingElse) {
  const std::string text =
      "# Grüße\nname = \"a\" # the name\n[controller]\nv_max = 0.1   # m/s\n[controller.gains]\nk_xx = 1\n";
  const auto changed = with_toml_value(text, "controller.v_max", "0.08");
  ASSERT_TRUE(changed.has_value()) << changed.error();
  EXPECT_EQ(*changed,
            "# Grüße\nname = \"a\" # the name\n[controller]\nv_max = 0.08   # m/s\n[controller.gains]\nk_xx = 1\n");
  EXPECT_EQ(toml_value(text, "name"), "\"a\"");
  EXPECT_EQ(toml_value(text, "controller.gains.k_xx"), "1");
  EXPECT_EQ(toml_value(text, "controller.k_y"), std::nullopt);
}

TEST(TomlEdit, CountsCharactersNotBytes) {
  const auto changed = with_toml_value("a = \"é\", b = 1\n", "b", "2");
  EXPECT_FALSE(changed.has_value()) << "no TOML";
  EXPECT_EQ(with_toml_value("a = { \"é\" = 1, b = 1 } # é\n", "a.b", "2").value(), "a = { \"é\" = 1, b = 2 } # é\n");
}

TEST(TomlEdit, AddsAKeyBehindThoseOfItsTable) {
  const std::string text = "name = \"a\"\n\n[controller]\nv_max = 0.1\n\n[shield]\nenabled = true\n";
  EXPECT_EQ(with_toml_value(text, "seed", "7").value(),
            "name = \"a\"\nseed = 7\n\n[controller]\nv_max = 0.1\n\n[shield]\nenabled = true\n");
  EXPECT_EQ(with_toml_value(text, "controller.k", "7").value(),
            "name = \"a\"\n\n[controller]\nv_max = 0.1\nk = 7\n\n[shield]\nenabled = true\n");
  EXPECT_EQ(with_toml_value(text, "arena.width", "3").value(), text + "\n[arena]\nwidth = 3\n");
  EXPECT_EQ(with_toml_value("[arena]\nwidth = 3\n", "seed", "7").value(), "seed = 7\n[arena]\nwidth = 3\n");
  EXPECT_EQ(with_toml_value("", "seed", "7").value(), "seed = 7\n");
}

TEST(TomlEdit, RefusesWhatItCannotWrite) {
  EXPECT_FALSE(with_toml_value("name = ", "seed", "7").has_value());
  EXPECT_FALSE(with_toml_value("name = 1\n", "seed", "7 8").has_value());
  EXPECT_FALSE(with_toml_value("[a.b]\nc = 1\n", "a.d", "7").has_value()) << "a has no header of its own";
}

TEST(TomlEdit, KeepsThePapersExperimentWhatItIs) {
  const Experiment before = paper_experiment();
  for (const auto& [key, value] : {std::pair{"controller.v_max", "0.09"},
                                   {"controller.gains.k_yy", "0.05"},
                                   {"shield.distance", "0.08"},
                                   {"simulation.latency", "0.02"},
                                   {"seed", "9"}}) {
    const auto text = with_toml_value(before.source, key, value);
    ASSERT_TRUE(text.has_value()) << key << ": " << text.error();
    const auto experiment = parse_experiment(*text, "edited");
    ASSERT_TRUE(experiment.has_value()) << key << ": " << experiment.error().front().message();
    EXPECT_EQ(toml_value(*text, key), value);
    EXPECT_EQ(experiment->perturbations.size(), before.perturbations.size());
  }
}

}  // namespace
}  // namespace skein::app
