#pragma once

#include <QElapsedTimer>
#include <QLabel>
#include <QSlider>
#include <QTimer>
#include <QWidget>
#include <functional>
#include <optional>

#include "core/control/gain_schedule.h"
#include "ui/base/number_field.h"

namespace skein::ui {

/// A slider whose track shows how far a gain may go: beyond the first mark lies what (18) forbids somewhere along the
/// reference, beyond the second what it forbids now.
class LimitSlider final : public QSlider {
  Q_OBJECT

 public:
  static constexpr int steps = 1000;

  explicit LimitSlider(QWidget* parent = nullptr);
  /// As shares of the track, 0 to 1: the limit over the whole reference, the limit now, the gain now.
  void set_marks(double limit, double limit_now, double now);
  double limit_mark() const { return limit_; }
  double now_mark() const { return now_; }
  QSize sizeHint() const override;

 protected:
  void paintEvent(QPaintEvent*) override;
  void wheelEvent(QWheelEvent*) override;

 private:
  double limit_ = 1.0, limit_now_ = 1.0, now_ = 0.0;
};

/// One coupling gain: what is asked for, what it is now, and where its limit lies.
class GainSlider final : public QWidget {
  Q_OBJECT

 public:
  GainSlider(core::GainName gain, QWidget* parent = nullptr);

  /// A new experiment: the value of its file.
  void reset(double value, double limit);
  void set_limit(double limit, double limit_now);
  void set_now(double value);  ///< what governs the robots now, on its way to the target
  /// What the gain is on its way to, whoever has asked for it. What the operator is about to ask for is left alone: a
  /// number that is being typed, a knob that is held, a wish that the session cannot have taken yet.
  void follow_target(double value);
  void set_target(double value);  ///< the same, at once
  double target() const { return spin_->value(); }
  /// What makes room for a value beyond the limit; empty: nothing is to be said.
  using Remedy = std::function<QString(double wanted)>;
  void set_remedy(Remedy remedy) { remedy_ = std::move(remedy); }
  /// The session has clamped what was asked for. It is explained as long as the gain stays there for that reason.
  void note_held(double asked, double held);
  /// Why nothing is drawn ahead while the knob is held, for its tip; empty: something is.
  void set_no_preview(const QString& why);
  QWidget* first_control() const { return slider_; }

 signals:
  void wanted(skein::core::GainName gain, double value);
  void refused(const QString& why);
  /// The knob is being moved: by the mouse until it is let go, by keys until a second after the last.
  void held(skein::core::GainName gain, double value);
  void let_go();

 private:
  void choose(double value);
  int step_of(double value) const;  // where the knob stands for it
  void set_range(double top);
  void show_text();
  QString advice() const;
  QString gain_text(double value) const;
  QString limit_text(double value) const;
  double half_a_step() const;  // of what is shown

  core::GainName gain_;
  LimitSlider* slider_;
  NumberField* spin_;
  QLabel *now_text_, *limit_text_, *advice_text_;
  Remedy remedy_;
  QString no_preview_;
  struct Held {
    double asked, at;
  };
  std::optional<Held> held_back_;
  QTimer rest_;          // a drag along the slider is one wish, made when the hand rests
  QTimer last_key_;      // that moved the knob
  QElapsedTimer asked_;  // since the last wish; invalid: the session has had time to take it
  double top_ = 1.0, limit_ = 0.0, limit_now_ = 0.0, now_ = 0.0;
};

}  // namespace skein::ui
