-- Tables of a run file. boot is the number that a board draws when it starts.
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT);
-- one row a sample of the board: board_us its clock in microseconds, without wraps; vacuum and
-- target in Pa (NULL: no number); temperature in 0.01 degC of the sensor; pump 0 to 255;
-- flags 1 vent open, 2 pump backwards, 4 sync, 8 emergency stop, 16 external contact;
-- state 0 SAFE, 1 RUN, 2 FAULT, 3 DRIVE
CREATE TABLE samples (
  boot INTEGER, seq INTEGER, board_us INTEGER, vacuum REAL, target REAL, raw INTEGER,
  temperature INTEGER, pump INTEGER, flags INTEGER, state INTEGER, fault INTEGER,
  PRIMARY KEY (boot, seq)
) WITHOUT ROWID;
-- the host's clocks when a block had come whose last sample is seq
CREATE TABLE clock (
  boot INTEGER, seq INTEGER, board_us INTEGER, host_mono_ns INTEGER, host_utc_ns INTEGER
);
-- kind: step, prompt, answer, error, fault, link, note
CREATE TABLE events (host_utc_ns INTEGER, board_us INTEGER, kind TEXT, text TEXT);
-- elongation in m, force in N
CREATE TABLE crosshead (board_us INTEGER PRIMARY KEY, elongation REAL, force REAL);
-- accelerations: trigger_us on the clock of board_us; samples of the whole record, pre of them
-- before the trigger; scale is JSON: zero (counts at 0), gain (m/s^2 a count), range (m/s^2)
CREATE TABLE shots (
  shot INTEGER PRIMARY KEY, boot INTEGER, rate REAL, scale TEXT, trigger_us INTEGER, pre INTEGER,
  samples INTEGER
);
-- n counts from the sample first on, int16, little-endian
CREATE TABLE shot_data (
  shot INTEGER, first INTEGER, n INTEGER, data BLOB, PRIMARY KEY (shot, first)
);
