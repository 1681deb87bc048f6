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

/// A slider whose track shows how far a gain may go: beyond the first mark are values that (18) forbids somewhere along
/// the reference, beyond the second those that it forbids now.
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

/// One coupling gain: the requested value, the present value and the limit.
class GainSlider final : public QWidget {
  Q_OBJECT

 public:
  GainSlider(core::GainName gain, QWidget* parent = nullptr);

  /// A new experiment: the value of its file.
  void reset(double value, double limit);
  void set_limit(double limit, double limit_now);
  void set_now(double value);  ///< the value in force, on its way to the target
  /// Shows the gain's target, whatever set it. Leaves alone what the operator is about to request: a number that is
  /// being typed, a knob that is held, a request that the session cannot have executed yet.
  void follow_target(double value);
  void set_target(double value);  ///< the same, at once
  double target() const { return spin_->value(); }
  /// A text on how to make room for a value beyond the limit; empty: none.
  using Remedy = std::function<QString(double wanted)>;
  void set_remedy(Remedy remedy) { remedy_ = std::move(remedy); }
  /// The session has clamped the requested value. The explanation stays as long as the gain stays there for that
  /// reason.
  void note_held(double asked, double held);
  /// Why there is no preview while the knob is held, for its tip; empty: there is one.
  void set_no_preview(const QString& why);
  QWidget* first_control() const { return slider_; }

 signals:
  void wanted(skein::core::GainName gain, double value);
  void refused(const QString& why);
  /// The knob is being moved: by the mouse until it is released, by keys until a second after the last one.
  void held(skein::core::GainName gain, double value);
  void let_go();

 private:
  void choose(double value);
  int step_of(double value) const;  // the knob's position for it
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
  QTimer rest_;          // a drag along the slider is one request, made when the mouse rests
  QTimer last_key_;      // that moved the knob
  QElapsedTimer asked_;  // since the last request; invalid: the session has had time to execute it
  double top_ = 1.0, limit_ = 0.0, limit_now_ = 0.0, now_ = 0.0;
};

}  // namespace skein::ui
