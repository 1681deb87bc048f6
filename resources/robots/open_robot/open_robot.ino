// A home-made robot on an ESP32: the open protocol over WiFi (docs/open-protocol.md). Fill in network, pins and measures.
#include <WiFi.h>
#include <WiFiUdp.h>

#include "open_robot.h"

static const char* const network = "lab";
static const char* const password = "";
static const int left_pwm = 25, left_back = 26, right_pwm = 32, right_back = 33;            // motor driver
static const int left_a = 18, left_b = 19, right_a = 22, right_b = 23, battery_pin = 34;    // encoders, divider 1:4
static const float tenths_per_pulse = 0.714f;  // way of the rim for one edge of A, in 0.1 mm: pi x 650 / 2860
static const float gain = 0.02f, feed = 0.05f;  // of the speed controller: duty (0 to 255) per 0.1 mm/s

static WiFiUDP udp;
static open_robot robot;
static volatile int32_t left_pulses = 0, right_pulses = 0;

static void IRAM_ATTR on_left() { left_pulses += digitalRead(left_b) ? -1 : 1; }
static void IRAM_ATTR on_right() { right_pulses += digitalRead(right_b) ? 1 : -1; }

static void send(void*, const uint8_t* bytes, size_t size) {
  udp.beginPacket(udp.remoteIP(), udp.remotePort());
  udp.write(bytes, size);
  udp.endPacket();
}

static void turn(int pwm, int back, float duty) {
  digitalWrite(back, duty < 0);
  analogWrite(pwm, (int)fminf(fabsf(duty), 255.0f));
}

// A proportional controller with feed-forward; 0 is off at once, whatever the encoders say.
static void drive(int pwm, int back, int16_t wanted, float speed) {
  turn(pwm, back, wanted == 0 ? 0.0f : feed * wanted + gain * (wanted - speed));
}

void setup() {
  for (const int pin : {left_pwm, left_back, right_pwm, right_back}) pinMode(pin, OUTPUT);
  for (const int pin : {left_a, left_b, right_a, right_b}) pinMode(pin, INPUT_PULLUP);
  attachInterrupt(digitalPinToInterrupt(left_a), on_left, RISING);
  attachInterrupt(digitalPinToInterrupt(right_a), on_right, RISING);
  open_robot_config config = {"robot 1", 4000, 1000, 6800, send};
  open_robot_begin(&robot, &config, nullptr);
  WiFi.begin(network, password);
  WiFi.setSleep(false);  // power saving would add 100 ms to every answer
  udp.begin(OPEN_ROBOT_PORT);
}

void loop() {
  static uint32_t last = 0;
  static int32_t left_before = 0, right_before = 0;
  static float left_speed = 0, right_speed = 0;
  uint8_t bytes[128];
  const int size = udp.parsePacket();
  if (size > 0) {
    const int count = udp.read(bytes, sizeof bytes);
    if (count > 0) open_robot_hear(&robot, bytes, (size_t)count, millis());
  }
  const uint32_t now = millis();
  if (now - last < 10) return;
  const float seconds = 1e-3f * (float)(now - last);
  last = now;
  const int32_t left = (int32_t)(tenths_per_pulse * (float)left_pulses), right = (int32_t)(tenths_per_pulse * (float)right_pulses);
  left_speed = (float)(left - left_before) / seconds, right_speed = (float)(right - right_before) / seconds;
  left_before = left, right_before = right;
  open_robot_measure(&robot, left, right, (uint16_t)(4 * analogReadMilliVolts(battery_pin)));
  int16_t left_wanted, right_wanted;
  open_robot_wheels(&robot, now, &left_wanted, &right_wanted);  // the watchdog is in here
  drive(left_pwm, left_back, left_wanted, left_speed);
  drive(right_pwm, right_back, right_wanted, right_speed);
}
