/* A controller in C, as its users write it: a library and, with main(), a program. */
#define _GNU_SOURCE /* NOLINT(bugprone-reserved-identifier): the C library's own */
#define SKEIN_CLIENT
#include "app/controllers/skein_controller.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const skein_parameter parameters[] = {
    {"k_x", "1/s", "how fast the error ahead is corrected", 0.0, 20.0, 2.0},
    {"k_y", "rad/(m s)", "steering towards the reference", 0.0, 50.0, 8.0},
};
static const char* const logs[] = {"distance", "robot"};

static void step(void* state, skein_memory* memory) {
  uint32_t i;
  (void)state;
  for (i = 0; i < memory->robots; ++i) {
    const skein_robot* const robot = &memory->robot[i];
    memory->command[i].v = robot->reference[3] * cos(robot->error[2]) + memory->parameter[0].value * robot->error[0];
    memory->command[i].omega =
        robot->reference[4] + 3.0 * sin(robot->error[2]) + memory->parameter[1].value * robot->error[1];
    memory->log[i][0] = hypot(robot->error[0], robot->error[1]);
    memory->log[i][1] = i + 1.0;
  }
}

static const skein_controller controller = {SKEIN_CONTROLLER_VERSION, 2, 2, parameters, logs, 0, step, 0};

const skein_controller* skein_controller_v1(void) {
  static skein_controller other;
  other = controller;
  if (getenv("SKEIN_TEST_LAW_OF_ANOTHER_VERSION")) ++other.version;
  return &other;
}

/* skein_test_law [REFUSAL]: the same as a program; with words it refuses. */
int main(int count, char** words) {
  skein_memory* const memory = skein_attach();
  uint64_t question;
  if (!memory) return 2;
  if (count > 1) strncpy(memory->refusal, words[1], sizeof memory->refusal - 1);
  memcpy(memory->parameter, parameters, sizeof parameters);
  memory->parameters = 2;
  memory->declared = 1;
  skein_ready();
  while ((question = skein_wait(memory)) != 0) {
    step(0, memory);
    skein_answer(memory, question);
  }
  return 0;
}
