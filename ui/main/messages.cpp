#include "ui/main/messages.h"

#include "ui/base/dialogs.h"
#include "ui/status/alert_strip.h"
#include "ui/status/event_log.h"

#include "ui/base/tr.h"

namespace skein::ui {

QString reading_text(const QString& file) {
  return tr("Reading %1 …").arg(file);
}

void Messages::say(const QString& text, Severity severity) const {
  alert_->say(text, severity);
}

void Messages::say_beside_banner(const QString& text, Severity severity) const {
  alert_->say(text, severity, AlertStrip::Also::in_banner);
}

void Messages::note(const QString& text, Severity severity) const {
  log_->note(runs_.shown().t(), text, severity);
  alert_->say(text, severity);
}

void Messages::note_unkept(const QString& text) const {
  note(text, Severity::alarm);
  alert_->warn_unkept(text);
}

void Messages::tell(const RunSource::Done& done) const {
  if (!done) say(QString::fromStdString(done.error()), Severity::warning);
}

void Messages::problem(const QString& title, const QString& text, const QString& details) const {
  say(title, Severity::warning);  // also in place of "Reading ..." and the like
  show_problem(title, text, details);
}

void Messages::show_problem(const QString& title, const QString& text, const QString& details) const {
  QString body = text.toHtmlEscaped().replace(QLatin1Char('\n'), QStringLiteral("<br>"));
  if (!details.isEmpty())
    body +=
        QStringLiteral("<pre style=\"white-space: pre-wrap\">") + details.toHtmlEscaped() + QStringLiteral("</pre>");
  show_beside(new MessageDialog(QStringLiteral("problem_dialog"), title,
                                QStringLiteral("<p><b>%1</b></p><p>%2</p>").arg(title.toHtmlEscaped(), body), window_));
}

}  // namespace skein::ui
