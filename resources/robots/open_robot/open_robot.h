/* A robot that speaks the open protocol, version 1 (docs/open-protocol.md): bytes in, bytes and wheel speeds out. Plain
 * C99, no memory but its own, no clock, no I/O, so that a microcontroller and a test run the same lines.
 *
 * Give it every byte that arrives (open_robot_hear), tell it what encoders and battery say (open_robot_measure), and
 * drive the wheels as open_robot_wheels says, every 20 ms or more often: the watchdog is in there.
 */
#ifndef OPEN_ROBOT_H
#define OPEN_ROBOT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  OPEN_ROBOT_VERSION = 1,
  OPEN_ROBOT_PORT = 2626,       /* UDP */
  OPEN_ROBOT_WATCHDOG_MS = 200, /* no speeds for so long: it stands */
  OPEN_ROBOT_HEAD = 7,          /* "Sk", version, kind, number (2), size */
  OPEN_ROBOT_CHECK = 2,         /* the check sum at a frame's end */
  OPEN_ROBOT_LONGEST_IN = 17,   /* a frame to the robot */
  OPEN_ROBOT_LONGEST_NAME = 24,
  OPEN_ROBOT_LONGEST_OUT = 40   /* a frame from it */
};

/* Kinds of frames: to the robot in capitals. */
enum {
  OPEN_ROBOT_STOP = 'X',   /* nothing; obeyed in every version of the protocol, whatever its number */
  OPEN_ROBOT_WHEELS = 'W', /* left, right: int16 [0.1 mm/s] */
  OPEN_ROBOT_TWIST = 'T',  /* forward int16 [0.1 mm/s], turning to the left int16 [mrad/s] */
  OPEN_ROBOT_QUERY = 'Q',  /* nothing; does not feed the watchdog */
  OPEN_ROBOT_HELLO = 'H',  /* nothing; likewise */
  OPEN_ROBOT_STATUS = 's', /* the answer to all but a hello: flags, taken speeds, way of the wheels, battery */
  OPEN_ROBOT_NAME = 'h'    /* the answer to a hello, and to another version: watchdog, fastest, track, name */
};

/* Flags of a status. */
enum {
  OPEN_ROBOT_TIMED_OUT = 1, /* the watchdog has stopped it */
  OPEN_ROBOT_REFUSED = 2,   /* what this answers was not obeyed: it is older than what was, or no stop has come yet */
  OPEN_ROBOT_BOOTED = 4,    /* no stop has come since it was switched on */
  OPEN_ROBOT_LOW = 8        /* its battery is low */
};

struct open_robot_config {
  const char* name;
  uint16_t fastest;     /* that a wheel rolls [0.1 mm/s] */
  uint16_t track;       /* between the wheels [0.1 mm] */
  uint16_t low_battery; /* below this it is low [mV] */
  /* Sends an answer; `to` is what open_robot_begin was given. Over UDP: a datagram to whoever spoke last. */
  void (*send)(void* to, const uint8_t* bytes, size_t size);
};

struct open_robot {
  struct open_robot_config config;
  void* to;
  uint8_t frame[OPEN_ROBOT_LONGEST_IN]; /* what has come of the next one */
  size_t held;
  int16_t left, right; /* taken [0.1 mm/s] */
  int32_t left_way, right_way;
  uint16_t battery, number; /* `number`: of what was obeyed last */
  uint32_t commanded_at;
  uint8_t flags;
};

void open_robot_begin(struct open_robot* robot, const struct open_robot_config* config, void* to);
/* Bytes have come, in chunks of any size. `now`: milliseconds, may wrap around. */
void open_robot_hear(struct open_robot* robot, const uint8_t* bytes, size_t size, uint32_t now);
/* What each wheel has rolled since it was switched on [0.1 mm], wraps around; battery [mV], 0: not known. */
void open_robot_measure(struct open_robot* robot, int32_t left_way, int32_t right_way, uint16_t battery);
/* How fast the wheels are to roll now [0.1 mm/s]: 0 when the watchdog's time is over. */
void open_robot_wheels(struct open_robot* robot, uint32_t now, int16_t* left, int16_t* right);

/* The check sum of a frame: CRC-16/CCITT-FALSE. */
uint16_t open_robot_crc(const uint8_t* bytes, size_t size);

#ifdef __cplusplus
}
#endif
#endif
