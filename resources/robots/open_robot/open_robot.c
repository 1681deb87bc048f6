#include "open_robot.h"

#include <string.h>

uint16_t open_robot_crc(const uint8_t* bytes, size_t size) {
  uint16_t crc = 0xFFFF;
  for (size_t i = 0; i < size; ++i) {
    crc = (uint16_t)(crc ^ ((unsigned)bytes[i] << 8));
    for (int bit = 0; bit < 8; ++bit)
      crc = (uint16_t)((crc & 0x8000u) ? ((unsigned)crc << 1) ^ 0x1021u : (unsigned)crc << 1);
  }
  return crc;
}

static void put16(uint8_t* at, uint16_t value) {
  at[0] = (uint8_t)(value & 0xFF);
  at[1] = (uint8_t)(value >> 8);
}
static void put32(uint8_t* at, uint32_t value) {
  put16(at, (uint16_t)(value & 0xFFFF));
  put16(at + 2, (uint16_t)(value >> 16));
}
static uint16_t get16(const uint8_t* at) { return (uint16_t)(at[0] | (unsigned)at[1] << 8); }
static int16_t get_signed(const uint8_t* at) {
  const uint16_t value = get16(at);
  return (int16_t)(value < 0x8000u ? (int32_t)value : (int32_t)value - 0x10000);
}

static void answer(struct open_robot* robot, uint8_t kind, uint16_t number, const uint8_t* payload, size_t size) {
  uint8_t out[OPEN_ROBOT_LONGEST_OUT] = {'S', 'k', OPEN_ROBOT_VERSION};
  out[3] = kind;
  put16(out + 4, number);
  out[6] = (uint8_t)size;
  memcpy(out + OPEN_ROBOT_HEAD, payload, size);
  const size_t end = OPEN_ROBOT_HEAD + size;
  put16(out + end, open_robot_crc(out + 2, end - 2));
  robot->config.send(robot->to, out, end + OPEN_ROBOT_CHECK);
}

static void answer_status(struct open_robot* robot, uint16_t number, uint8_t refused) {
  uint8_t payload[15];
  const uint8_t low = robot->battery != 0 && robot->battery < robot->config.low_battery ? OPEN_ROBOT_LOW : 0;
  payload[0] = (uint8_t)(robot->flags | refused | low);
  put16(payload + 1, (uint16_t)robot->left);
  put16(payload + 3, (uint16_t)robot->right);
  put32(payload + 5, (uint32_t)robot->left_way);
  put32(payload + 9, (uint32_t)robot->right_way);
  put16(payload + 13, robot->battery);
  answer(robot, OPEN_ROBOT_STATUS, number, payload, sizeof payload);
}

static void answer_name(struct open_robot* robot, uint16_t number) {
  uint8_t payload[6 + OPEN_ROBOT_LONGEST_NAME];
  size_t length = strlen(robot->config.name);
  if (length > OPEN_ROBOT_LONGEST_NAME) length = OPEN_ROBOT_LONGEST_NAME;
  put16(payload, OPEN_ROBOT_WATCHDOG_MS);
  put16(payload + 2, robot->config.fastest);
  put16(payload + 4, robot->config.track);
  memcpy(payload + 6, robot->config.name, length);
  answer(robot, OPEN_ROBOT_NAME, number, payload, 6 + length);
}

static int16_t bounded(int32_t speed, uint16_t fastest) {
  const int32_t most = fastest < 0x7FFF ? fastest : 0x7FFF;
  return (int16_t)(speed > most ? most : speed < -most ? -most : speed);
}

/* Speeds are obeyed after a first stop, and when nothing newer has been: datagrams may overtake one another. */
static uint8_t drive(struct open_robot* robot, uint16_t number, int32_t left, int32_t right, uint32_t now) {
  const uint16_t ahead = (uint16_t)(number - robot->number);
  if ((robot->flags & OPEN_ROBOT_BOOTED) || ahead == 0 || ahead >= 0x8000u) return OPEN_ROBOT_REFUSED;
  robot->left = bounded(left, robot->config.fastest);
  robot->right = bounded(right, robot->config.fastest);
  robot->number = number;
  robot->commanded_at = now;
  robot->flags &= (uint8_t)~OPEN_ROBOT_TIMED_OUT;
  return 0;
}

static void obey(struct open_robot* robot, const uint8_t* frame, uint32_t now) {
  const uint8_t kind = frame[3], size = frame[6];
  const uint8_t* const payload = frame + OPEN_ROBOT_HEAD;
  const uint16_t number = get16(frame + 4);
  if (kind == OPEN_ROBOT_STOP) { /* in any version */
    robot->left = robot->right = 0;
    robot->number = number;
    robot->flags = 0;
    answer_status(robot, number, 0);
  } else if (frame[2] != OPEN_ROBOT_VERSION || kind == OPEN_ROBOT_HELLO) {
    answer_name(robot, number);
  } else if (kind == OPEN_ROBOT_QUERY) {
    answer_status(robot, number, 0);
  } else if (kind == OPEN_ROBOT_WHEELS && size == 4) {
    answer_status(robot, number, drive(robot, number, get_signed(payload), get_signed(payload + 2), now));
  } else if (kind == OPEN_ROBOT_TWIST && size == 4) {
    /* mrad/s times 0.1 mm is a thousandth of 0.1 mm/s; each wheel is half a track out */
    const int32_t forward = get_signed(payload), turn = get_signed(payload + 2);
    const int32_t half = (int32_t)((int64_t)turn * robot->config.track / 2000);
    answer_status(robot, number, drive(robot, number, forward - half, forward + half, now));
  }
}

void open_robot_begin(struct open_robot* robot, const struct open_robot_config* config, void* to) {
  memset(robot, 0, sizeof *robot);
  robot->config = *config;
  robot->to = to;
  robot->flags = OPEN_ROBOT_BOOTED;
}

/* The bytes that are needed before anything can be said of those held; as many as are held: it is a frame, or debris. */
static size_t wanted(const struct open_robot* robot) {
  const uint8_t* const f = robot->frame;
  if (robot->held >= 1 && f[0] != 'S') return 0;
  if (robot->held >= 2 && f[1] != 'k') return 0;
  if (robot->held < OPEN_ROBOT_HEAD) return OPEN_ROBOT_HEAD;
  const size_t whole = OPEN_ROBOT_HEAD + (size_t)f[6] + OPEN_ROBOT_CHECK;
  return whole > OPEN_ROBOT_LONGEST_IN ? 0 : whole;
}

static void drop(struct open_robot* robot, size_t count) {
  robot->held -= count;
  memmove(robot->frame, robot->frame + count, robot->held);
}

void open_robot_hear(struct open_robot* robot, const uint8_t* bytes, size_t size, uint32_t now) {
  for (size_t i = 0; i < size; ++i) {
    robot->frame[robot->held++] = bytes[i];
    while (robot->held > 0) {
      const size_t whole = wanted(robot);
      if (robot->held < whole) break;
      if (whole == 0 || get16(robot->frame + whole - OPEN_ROBOT_CHECK) !=
                            open_robot_crc(robot->frame + 2, whole - 2 - OPEN_ROBOT_CHECK)) {
        drop(robot, 1); /* a frame may begin inside what looked like one */
        continue;
      }
      obey(robot, robot->frame, now);
      drop(robot, whole);
    }
  }
}

void open_robot_measure(struct open_robot* robot, int32_t left_way, int32_t right_way, uint16_t battery) {
  robot->left_way = left_way;
  robot->right_way = right_way;
  robot->battery = battery;
}

void open_robot_wheels(struct open_robot* robot, uint32_t now, int16_t* left, int16_t* right) {
  if ((robot->left != 0 || robot->right != 0) && now - robot->commanded_at >= OPEN_ROBOT_WATCHDOG_MS) {
    robot->left = robot->right = 0;
    robot->flags |= OPEN_ROBOT_TIMED_OUT;
  }
  *left = robot->left;
  *right = robot->right;
}
