#include "ui/base/timing_text.h"

#include "ui/base/tr.h"

namespace skein::ui {
namespace {

QString late(const app::Histogram& late) {
  constexpr double ms = 1e3, most = 0.999;
  return tr("%1 ms (median), %2 ms (p99.9)")
      .arg(ms * late.quantile(0.5), 0, 'f', 2)
      .arg(ms * late.quantile(most), 0, 'f', 2);
}

}  // namespace

QString timing_text(const app::Timing& timing) {
  if (timing.tick.total() == 0) return {};
  const QString ticks = tr("Ticks late by %1").arg(late(timing.tick));
  const QString bare = timing.bare.total() > 0 ? tr("; a bare thread by %1").arg(late(timing.bare)) : QString();
  const QString priority = timing.priority > 0
                               ? tr("; real-time priority %1").arg(timing.priority)
                               : tr("; no real-time priority: %1").arg(QString::fromStdString(timing.no_priority));
  return ticks + bare + priority;
}

}  // namespace skein::ui
