# Which real recordings are trained on and which are held out. Needs DATA and data, the same as a resolved path; DATA holds the
# folders random, zigzag, turning, berthing as published.
kinds := random zigzag turning berthing
# Held out: one recording of each kind; of the random ones a run that was cut in three, whole.
HELD_OUT := random/random_06-Aug-2020_16_24_25_4 random/random_06-Aug-2020_16_24_25_5 \
  random/random_06-Aug-2020_16_24_25_6 zigzag/zigzag_31-Jul-2020_13_22_52 turning/turn_14-Sep-2020_14_16_04 \
  berthing/berthing_12-Nov-2020_11_14_47
held := $(HELD_OUT:%=$(data)/%.csv)
# Left out: parts of recordings that are there in full.
all := $(sort $(foreach kind,$(kinds),$(wildcard $(data)/$(kind)/*.csv)))
train := $(filter-out $(held) $(data)/turning/turn_cut_%,$(all))
ifeq ($(train),)
  $(error no recordings in $(data); expected the folders $(kinds))
endif
missing := $(filter-out $(all),$(held))
ifneq ($(missing),)
  $(error not found: $(missing))
endif
recordings_of = $(filter $(data)/$(1)/%,$(filter-out $(data)/turning/turn_cut_%,$(all)))
