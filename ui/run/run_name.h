#pragma once

#include <QString>

namespace skein::ui {

/// Whether a file is the record in the folder of a kept run.
bool is_kept_record(const QString& file);

/// What a recorded run, or another file, is called: a kept run by its folder, since the record of each is run.csv.
QString run_name(const QString& file);

}  // namespace skein::ui
