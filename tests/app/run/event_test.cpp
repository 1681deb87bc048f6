#include "app/run/event.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "app/run/operator_command.h"
#include "core/words.h"

namespace skein::app {
namespace {

/// Every kind of event with values of its own, and its words.
const std::vector<std::pair<Event, std::string>> all{
    {events::Start{}, "start"},
    {events::Pause{}, "pause"},
    {events::Resume{}, "resume"},
    {events::Stop{}, "stop"},
    {events::Perturb{1, 0.05, -0.15, 0.0}, "perturb r2 dx=0.05 dy=-0.15 dtheta=0"},
    {events::Kidnap{3, 0.1, 0.2, 3.0}, "kidnap r4 dx=0.1 dy=0.2 dtheta=3"},
    {events::Move{0, {0.1, 0.2, -1.5}}, "move r1 x=0.1 y=0.2 theta=-1.5"},
    {events::Hold{0}, "hold r1"},
    {events::Release{11}, "release r12"},
    {events::Kick{2, 0.25, -0.5}, "kick r3 vx=0.25 vy=-0.5"},
    {events::PutObstacle{11, {0.1, 0.2, 0.05}}, "obstacle o12 x=0.1 y=0.2 radius=0.05"},
    {events::Gain{core::GainName::k_tt, 0.025, 0.03}, "gain k_tt 0.025 -> 0.03"},
    {events::Gain{core::GainName::k_xx, 0.025, 0.03, 20.0}, "gain k_xx 0.025 -> 0.03 ramp=20"},
    {events::Schedule{core::GainName::l_tt, 100.0, 50.0}, "schedule l_tt 100 -> 50"},
    {events::ScheduleTracking{core::TrackingGain::k_theta, 0.5, 0.25}, "schedule k_theta 0.5 -> 0.25"},
    {events::GainHeld{core::GainName::k_yy, 1.0, 0.1 / 3.0}, "gain_held k_yy 1 -> 0.03333333333333333"},
    {events::PairGain{1, 2, core::GainName::k_xx, 0.008, 0.01}, "pair_gain r2 r3 k_xx 0.008 -> 0.01"},
    {events::PairGainHeld{1, 2, core::GainName::k_xx, 1.0, 0.01}, "pair_gain_held r2 r3 k_xx 1 -> 0.01"},
    {events::Parameter{ParameterName("alpha_l"), 0.8, 1.5}, "parameter alpha_l 0.8 -> 1.5"},
    {events::Couple{0, 3}, "couple r1 r4"},
    {events::Uncouple{0, 3}, "uncouple r1 r4"},
    {events::Lost{2}, "lost r3"},
    {events::Found{2}, "found r3"},
    {events::Avoid{2}, "avoid r3"},
    {events::Clear{2}, "clear r3"},
    {events::Stage{}, "stage"},
    {events::Staged{}, "staged"},
    {events::Deadlock{0}, "deadlock r1"},
    {events::DeadlineMissed{3}, "deadline_missed 3"},
    {events::VRise{0.06}, "v_rise 0.06"},
    {events::Link{2, LinkState::stale}, "link r3 stale"},
    {events::CameraMoved{events::only_camera, 4, 0.037, -0.02}, "camera_moved tags=4 by=0.037 turn=-0.02"},
    {events::CameraMoved{1, 4, 0.037, -0.02}, "camera_moved c2 tags=4 by=0.037 turn=-0.02"},
    {events::CameraMoved{1, 0, 0.037, -0.02, 5}, "camera_moved c2 tags=0 by=0.037 turn=-0.02 marks=5"},
    {events::CamerasDisagree{2, 1, 0, 0.045}, "cameras_disagree r3 c2 c1 by=0.045"},
    {events::CamerasDiffer{2, 1, 0, 0.008}, "cameras_differ r3 c2 c1 by=0.008"},
    {events::PicturesLate{1.1}, "pictures_late by=1.1"},
    {events::CameraLost{1}, "camera_lost c2"},
    {events::CameraFound{0}, "camera_found c1"},
    {events::NotSeen{2, core::NotSeen::lifted}, "not_seen r3 lifted"},
    {events::FilmBroken{}, "film_broken"},
    {events::NoWay{1}, "no_way r2"},
    {events::NoWay{1, 0}, "no_way r2 r1"},
    {events::NoWay{1, events::nobody, 0.002}, "no_way r2 margin=0.002"},
    {events::NoProgress{1, 0.31, Hindrance::shield}, "no_progress r2 0.31 shield"},
    {events::Outside{0, 0.01}, "outside r1 0.01"},
    {events::Controller{ControllerState::late}, "controller late"},
    {events::NoNumber{1}, "no_number r2"},
    {events::Runaway{1, 0.1}, "runaway r2 0.1"},
    {events::Obeys{1}, "obeys r2"}};

TEST(Event, WordsOfEveryKindAreReadBack) {
  std::vector<bool> seen(std::variant_size_v<Event>, false);
  for (const auto& [event, words] : all) {
    seen[event.index()] = true;
    EXPECT_EQ(describe(event), words);
    const auto read = parse_event(words);
    ASSERT_TRUE(read) << words;
    EXPECT_EQ(read->index(), event.index()) << words;
    EXPECT_EQ(describe(*read), words);
  }
  for (std::size_t k = 0; k < seen.size(); ++k) EXPECT_TRUE(seen[k]) << "no example of kind " << k;
}

TEST(Event, NonsenseIsNotRead) {
  for (const char* nonsense : {"",
                               "boo",
                               "lost",
                               "lost rx",
                               "lost r0",
                               "lost r1 r2",
                               "lost o1",
                               "perturb r1 dx=",
                               "perturb r1 dx=1 dy=2",
                               "perturb r1 dy=1 dx=2 dtheta=3",
                               "gain 1 2 3 4",
                               "gain k_xx 1 2",
                               "gain k_zz 1 -> 2",
                               "gain k_xx 1 -> 2 ramp",
                               "start now",
                               "link r1 open",
                               "couple r1",
                               "parameter 0.8 -> 1",
                               "parameter  0.8 -> 1",
                               "parameter a-b 0.8 -> 1",
                               "parameter a_name_of_more_than_thirty_one_letters 0.8 -> 1"})
    EXPECT_FALSE(parse_event(nonsense)) << nonsense;
}

TEST(Event, ActionsAreWhatAnOperatorDoes) {
  EXPECT_TRUE(parse_action("kick r2 vx=0.3 vy=0"));
  EXPECT_TRUE(parse_action("gain k_xx 0.008 -> 0.01 ramp=3"));
  EXPECT_TRUE(parse_action("parameter alpha_l 0.8 -> 1.5"));
  EXPECT_FALSE(parse_action("parameter alpha_l 0.8 -> inf"));
  EXPECT_FALSE(parse_action("start")) << "an experiment file does not start itself";
  EXPECT_FALSE(parse_action("lost r1"));
  EXPECT_FALSE(parse_action("kick r2 vx=nan vy=0"));
  EXPECT_FALSE(parse_action("gain k_xx 0.008 -> inf"));
}

TEST(Event, ACommandIsWhatMadeTheEvent) {
  const auto command = command_of(events::Uncouple{1, 2});
  ASSERT_TRUE(command);
  const auto* const couple = std::get_if<commands::Couple>(&*command);
  ASSERT_NE(couple, nullptr);
  EXPECT_EQ(couple->i, 1u);
  EXPECT_EQ(couple->j, 2u);
  EXPECT_FALSE(couple->on);
  EXPECT_FALSE(command_of(events::Kick{}));
  EXPECT_FALSE(command_of(events::GainHeld{}));
}

TEST(Event, AListThatOverflowedSaysSo) {
  EventList list(EventList::room_for(4));
  for (std::size_t k = 0; k < list.limit() + 2; ++k) list.add(events::Lost{0});
  EXPECT_TRUE(list.full());
  const std::string words = describe(list);
  EXPECT_TRUE(words.ends_with("lost r1; +2 more")) << words;
}

TEST(Words, OfEnumerationsAreFoundAgain) {
  for (const LinkState state : core::all_of<LinkState>()) EXPECT_EQ(core::from_word<LinkState>(word(state)), state);
  EXPECT_EQ(core::all_of<core::GainName>().size(), core::pair_names.size());
  EXPECT_FALSE(core::from_word<LinkState>(""));
  EXPECT_FALSE(core::from_word<LinkState>("uP"));
}

}  // namespace
}  // namespace skein::app
