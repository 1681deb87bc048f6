#pragma once

#include <string_view>

/// Files of resources/ that are part of the program (see CMakeLists.txt here), so that it finds them wherever it is
/// installed.
namespace skein::app::embedded {

extern const std::string_view platoon_toml;  ///< resources/experiments/platoon.toml
extern const std::string_view crowd_toml;    ///< resources/experiments/crowd.toml
extern const std::string_view figure3_gp;    ///< resources/figures/figure3.gp
extern const std::string_view figure4_gp;    ///< resources/figures/figure4.gp
extern const std::string_view residuals_gp;  ///< resources/figures/residuals.gp
extern const std::string_view page_html;     ///< resources/report/page.html
extern const std::string_view front_gp;      ///< resources/figures/front.gp

// Figures of a study: resources/figures/distributions.gp, shares.gp and worst.gp.
extern const std::string_view distributions_gp, shares_gp, worst_gp;

}  // namespace skein::app::embedded
