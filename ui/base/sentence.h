#pragma once

#include <QString>
#include <vector>

#include "app/run/event.h"
#include "app/run/status.h"

namespace skein::ui {

/// A gain as the sliders write it, where only plain text can stand: "k_θθ". The CSV's word for it is "k_tt".
QString gain_symbol(core::GainName gain);
QString gain_symbol(core::TrackingGain gain);

/// Why a tag is not seen, as half a sentence: "part of its tag is covered or blurred".
QString reason_text(core::NotSeen why);

/// The number in a robot's firmware version, "2.0" of "Version 2.0 January 2018"; the whole text if there is none.
QString version_number(const QString& version);

/// What happened, in a sentence for people, robots from 1. The log and the plots have the CSV's words beside it.
QString sentence(const app::Event& event);
/// The same, with the reason why a link is lost as far as `robots`, the status of each, have it.
QString sentence(const app::Event& event, const std::vector<app::RobotStatus>& robots);

}  // namespace skein::ui
