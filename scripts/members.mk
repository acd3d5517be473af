# An ensemble on one machine, a process for each member; interrupted, it goes on where it stopped:
#   make -j 8 -f scripts/members.mk MEMBERS=15 MODEL=model TRAIN="--config fast recordings/*.csv"
MEMBERS ?= 15
MODEL ?= model
ENS_TRAIN ?= ens-train
TRAIN ?= $(error TRAIN is missing: the arguments of ens-train but --output, --members and --member)

train := $(ENS_TRAIN) $(TRAIN) --output $(MODEL) --members $(MEMBERS) --resume
numbers := $(shell seq 0 $$(($(MEMBERS) - 1)))

.PHONY: ensemble $(numbers:%=member-%)
# Checks all members and completes ensemble.json.
ensemble: $(numbers:%=member-%)
	$(train) --jobs 1

# A member that is there already is kept.
$(numbers:%=member-%): member-%:
	$(train) --member $* --jobs 1
