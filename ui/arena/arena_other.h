#pragma once

#include <QPainter>

#include "ui/arena/arena_map.h"
#include "ui/arena/arena_scene.h"
#include "ui/base/palette.h"

namespace skein::ui {

/// The run that this one is compared with: ghosts of its robots, hollow and pale, and their trails.
void paint_other(QPainter& painter, const OtherRun& other, const ArenaScene& scene, const ArenaMap& map,
                 const Colours& colours);

/// Where the robots would go from now on: the same, without letters.
void paint_foreseen(QPainter& painter, const ArenaScene& scene, const ArenaMap& map, const Colours& colours);

}  // namespace skein::ui
