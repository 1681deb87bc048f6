/* Your own controller for Skein, in C or in any language that C can be called from: docs/controllers.md.
 *
 * Version 1. This header stands alone: C99, no dependency but stdint.h; define SKEIN_CLIENT before it is included to
 * get the functions of a controller that is a program of its own (POSIX; with -std=c99 define _POSIX_C_SOURCE as
 * 200809L before the first header).
 *
 * Units: SI (m, s, rad). World frame: the floor, x right, y up, theta counter-clockwise from +x. Robots in the order of
 * the experiment file. The same memory is mapped by Skein and by the controller; numbers are the machine's own (64-bit
 * little-endian on x86-64 and arm64), and no field has padding before it.
 */
#ifndef SKEIN_CONTROLLER_H
#define SKEIN_CONTROLLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SKEIN_CONTROLLER_VERSION 1
#define SKEIN_MAGIC "skeinlaw" /* the first 8 bytes of the memory */
#define SKEIN_ROBOTS 64
#define SKEIN_OBSTACLES 128
#define SKEIN_PARAMETERS 64
#define SKEIN_LOGS 16

/* One robot, 240 bytes. */
typedef struct skein_robot {
  double x, y, theta;      /* where it is when the command acts; NaN: never seen */
  double covariance[9];    /* of x, y, theta, row by row, when it was measured */
  double v, omega;         /* how it drives now */
  double nominal[5];       /* x, y, theta, v, omega of its place in the formation */
  double reference[5];     /* the same after avoidance: what is to be tracked */
  double error[3];         /* the reference seen from the robot: ahead, to its left, heading; 0 while it is out */
  double v_max, omega_max; /* limits that are applied after the controller */
  double out;              /* 1: lost or held; it stands, whatever is asked of it */
} skein_robot;

typedef struct skein_obstacle {
  double x, y, radius;
} skein_obstacle;

/* What a robot shall do: forward [m/s] and turning [rad/s]. What is no number makes it stand; so does what is not
 * written: every question comes with NaN in all commands and logs. */
typedef struct skein_command {
  double v, omega;
} skein_command;

/* A number that the experiment file may set, 184 bytes. Texts end with a 0 byte. */
typedef struct skein_parameter {
  char name[32];
  char unit[16];
  char help[112];
  double low, high, value;
} skein_parameter;

typedef struct skein_memory {
  char magic[8];                               /*   0 */
  uint32_t version;                            /*   8 */
  uint32_t bytes;                              /*  12: of all this */
  uint32_t robots;                             /*  16 */
  uint32_t obstacles;                          /*  20: that stand on the floor now */
  double period;                               /*  24: of the tick */
  double half_width, half_height;              /*  32: of the arena, whose middle is the origin */
  uint64_t question;                           /*  48: number of the tick's question, from 1 */
  int64_t tick;                                /*  56 */
  double t, dt;                                /*  64: time of the experiment, and since the question before */
  uint64_t answer;                             /*  80: number of the question that `command` answers */
  uint32_t parameters, logs;                   /*  88: how many there are of each */
  uint32_t declared;                           /*  96: 1: the controller has declared its parameters and logs */
  char refusal[156];                           /* 100: why the controller cannot drive this; empty: it can */
  skein_robot robot[SKEIN_ROBOTS];             /* 256 */
  skein_obstacle obstacle[SKEIN_OBSTACLES];    /* 15616 */
  skein_parameter parameter[SKEIN_PARAMETERS]; /* 18688 */
  char log_name[SKEIN_LOGS][32];               /* 30464 */
  skein_command command[SKEIN_ROBOTS];         /* 30976 */
  double log[SKEIN_ROBOTS][SKEIN_LOGS];        /* 32000 */
} skein_memory;                                /* 40192 */

/* --- (b) a shared library: it exports one function ------------------------------------------------------------- */

typedef struct skein_controller {
  uint32_t version; /* SKEIN_CONTROLLER_VERSION */
  uint32_t parameter_count, log_count;
  const skein_parameter* parameters; /* with their ranges and defaults; may be null */
  const char* const* logs;           /* names, each of at most 31 bytes; may be null */
  /* Once, after the file's parameters are in `memory`; what it returns goes to `step`. May be null. */
  void* (*open)(const skein_memory* memory);
  /* Every tick: reads memory->robot and so on, writes memory->command and memory->log. */
  void (*step)(void* state, skein_memory* memory);
  void (*close)(void* state); /* may be null */
} skein_controller;

typedef const skein_controller* (*skein_controller_function)(void);
const skein_controller* skein_controller_v1(void); /* you write this one */

/* --- (c) a program of its own: what it is started with ---------------------------------------------------------- */

#define SKEIN_MEMORY_FD 3   /* the memory: to be mapped, or read and written as a file */
#define SKEIN_QUESTION_FD 4 /* a pipe: a byte comes with each question; its end: go */
#define SKEIN_ANSWER_FD \
  5 /* a pipe: write a byte when you are ready ('w': also announce questions), after each answer */

#ifdef SKEIN_CLIENT
/* NOLINTBEGIN(modernize-use-nullptr): this is C as well. */
#include <errno.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#define SKEIN_WATCH_SECONDS 0.003 /* after a 'w', how long to watch for the question before sleeping again */

/* The memory, or null: not started by Skein, or by another version. */
static inline skein_memory* skein_attach(void) {
  void* const at = mmap(0, sizeof(skein_memory), PROT_READ | PROT_WRITE, MAP_SHARED, SKEIN_MEMORY_FD, 0);
  skein_memory* const memory = (skein_memory*)at;
  const char* const magic = SKEIN_MAGIC;
  int k;
  if (at == MAP_FAILED) return 0;
  for (k = 0; k < 8; ++k)
    if (memory->magic[k] != magic[k]) return 0;
  return memory->version == SKEIN_CONTROLLER_VERSION ? memory : 0;
}

/* Says that declarations are made and questions may come, each announced by a 'w' shortly before it. */
static inline void skein_ready(void) {
  while (write(SKEIN_ANSWER_FD, "w", 1) < 0 && errno == EINTR) {
  }
}

/* Watches the memory for a question other than this one: a processor that is awake answers sooner. */
static inline uint64_t skein_watch(const skein_memory* memory, uint64_t answered) {
  struct timespec began, now;
  uint64_t question = answered;
  clock_gettime(CLOCK_MONOTONIC, &began);
  do {
    int k;
    for (k = 0; k < 64 && question == answered; ++k) question = __atomic_load_n(&memory->question, __ATOMIC_ACQUIRE);
    clock_gettime(CLOCK_MONOTONIC, &now);
  } while (question == answered &&
           (double)(now.tv_sec - began.tv_sec) + 1e-9 * (double)(now.tv_nsec - began.tv_nsec) < SKEIN_WATCH_SECONDS);
  return question;
}

/* Waits for the next question; its number, 0: the run is over. */
static inline uint64_t skein_wait(skein_memory* memory) {
  static uint64_t answered;
  char bytes[256];
  for (;;) {
    const ssize_t n = read(SKEIN_QUESTION_FD, bytes, sizeof bytes);
    uint64_t question = __atomic_load_n(&memory->question, __ATOMIC_ACQUIRE);
    if (n == 0 || (n < 0 && errno != EINTR)) return 0;
    if (n > 0 && question == answered && bytes[n - 1] == 'w') question = skein_watch(memory, answered);
    if (n > 0 && question != answered) return answered = question;
  }
}

/* Says that memory->command answers this question. */
static inline void skein_answer(skein_memory* memory, uint64_t question) {
  __atomic_store_n(&memory->answer, question, __ATOMIC_RELEASE);
  while (write(SKEIN_ANSWER_FD, "a", 1) < 0 && errno == EINTR) {
  }
}
/* NOLINTEND(modernize-use-nullptr) */
#endif /* SKEIN_CLIENT */

#ifdef __cplusplus
}
#endif

#endif
