! Calls VUINTER and VUMAT as Abaqus/Explicit does and compares with the law called directly, bit for bit.
! usage: abaqus_host LAW [time], the law in QUOIN_LAW_PATH; abaqus_host FAULT, one of the names in provoke.
module direct_law
  use quoin
  implicit none
  integer, parameter :: max_states = 16

  ! The law through the C ABI alone, one column an array, in the law's own signs.
  type :: direct
    type(quoin_law), pointer :: law => null()
    type(c_ptr) :: material
    integer :: count, state_count
    real(c_double), allocatable :: jump(:), slip(:, :), traction(:, :), state(:, :), stored(:), dissipated(:, :)
  contains
    final :: close_direct
  end type

contains

  subroutine open_direct(points, path, ids, numbers, count)
    type(direct), intent(out) :: points
    character(*), intent(in) :: path
    character(kind=c_char, len=*), intent(in), target :: ids(:)
    real(c_double), intent(in), target :: numbers(:)
    integer, intent(in) :: count
    procedure(create_material_function), pointer :: create
    procedure(initial_state_function), pointer :: initial_state
    type(quoin_property_value), target :: values(size(ids))
    type(c_ptr) :: pointers(size(ids))
    type(c_ptr), pointer :: initial_states(:)
    type(quoin_text) :: text
    character(:), allocatable :: reason
    real(c_double) :: initial(max_states)
    integer :: i
    points%law => open_law(path, reason)
    if (.not. associated(points%law)) then
      print *, reason
      error stop 1
    end if
    do i = 1, size(ids)
      values(i)%id = c_loc(ids(i))
      values(i)%number_count = 1
      values(i)%numbers = c_loc(numbers(i))
      pointers(i) = c_loc(values(i))
    end do
    call c_f_procpointer(points%law%create_material, create)
    if (create(points%law, size(ids, kind=c_int64_t), pointers, points%material, text) /= 0) error stop "refused"
    call c_f_procpointer(points%law%initial_state, initial_state)
    call c_f_pointer(points%law%initial_states, initial_states, [points%law%initial_state_count])
    if (initial_state(points%material, initial_states(1), initial) /= 0) error stop "no initial state"
    points%count = count
    points%state_count = int(points%law%state_count)
    allocate (points%jump(count), points%slip(count, 2), points%traction(count, 3), points%stored(count), &
              points%dissipated(count, 4), points%state(count, points%state_count))
    points%jump = 0
    points%slip = 0
    points%traction = 0
    do i = 1, points%state_count
      points%state(:, i) = initial(i)
    end do
  end subroutine

  impure elemental subroutine close_direct(points)
    type(direct), intent(inout) :: points
    procedure(destroy_material_function), pointer :: destroy
    if (.not. associated(points%law)) return
    call c_f_procpointer(points%law%destroy_material, destroy)
    call destroy(points%material)
  end subroutine

  subroutine step_direct(points, energies)
    type(direct), intent(inout), target :: points
    logical, intent(in) :: energies
    procedure(evaluate_function), pointer :: evaluate
    type(quoin_column), target :: states(max_states)
    type(quoin_batch) :: batch
    integer :: k
    batch%struct_size = c_sizeof(batch)
    batch%count = points%count
    batch%normal_jump = quoin_column(c_loc(points%jump(1)), 1)
    do k = 1, 2
      batch%slip_increment(k) = quoin_column(c_loc(points%slip(1, k)), 1)
    end do
    do k = 1, 3
      batch%traction_old(k) = quoin_column(c_loc(points%traction(1, k)), 1)
    end do
    batch%traction_new = batch%traction_old
    do k = 1, points%state_count
      states(k) = quoin_column(c_loc(points%state(1, k)), 1)
    end do
    batch%state_old = c_loc(states)
    batch%state_new = c_loc(states)
    if (energies) then
      batch%energy_stored = quoin_column(c_loc(points%stored(1)), 1)
      do k = 1, 4
        batch%dissipated(k) = quoin_column(c_loc(points%dissipated(1, k)), 1)
      end do
    end if
    call c_f_procpointer(points%law%evaluate, evaluate)
    if (evaluate(points%material, batch) /= 0 .or. batch%failed_count > 0) error stop "the direct batch failed"
  end subroutine

end module

module abaqus_calls
  use quoin
  implicit none

  interface
    subroutine vuinter(sfd, scd, spd, svd, stress, fluxSlv, fluxMst, sed, statev, kStep, kInc, nFacNod, nSlvNod, &
                       nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv, jSlvUid, jMstUid, &
                       jConMstid, timStep, timGlb, dTimCur, surfInt, surfSlv, surfMst, rdisp, drdisp, drot, &
                       stiffDflt, condDflt, shape, coordSlv, coordMst, alocaldir, props, areaSlv, tempSlv, dtempSlv, &
                       preDefSlv, dpreDefSlv, tempMst, dtempMst, preDefMst, dpreDefMst)
      import
      character(80) :: surfInt, surfSlv, surfMst
      integer :: kStep, kInc, nFacNod, nSlvNod, nMstNod, nSurfDir, nDir, nStateVar, nProps, nTemp, nPred, numDefTfv
      integer :: jSlvUid(*), jMstUid(*), jConMstid(*)
      real(c_double) :: stress(nDir, nSlvNod), statev(nStateVar, nSlvNod), rdisp(nDir, nSlvNod), drdisp(nDir, nSlvNod)
      real(c_double) :: sed(nSlvNod), sfd(nSlvNod), scd(nSlvNod), spd(nSlvNod), svd(nSlvNod), props(nProps)
      real(c_double) :: fluxSlv(*), fluxMst(*), timStep, timGlb, dTimCur, drot(*), stiffDflt(*), condDflt(*), shape(*), &
                        coordSlv(*), coordMst(*), alocaldir(*), areaSlv(*), tempSlv(*), dtempSlv(*), preDefSlv(*), &
                        dpreDefSlv(*), tempMst(*), dtempMst(*), preDefMst(*), dpreDefMst(*)
    end subroutine
    subroutine vumat(nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal, stepTime, totalTime, dt, cmname, coordMp, &
                     charLength, props, density, strainInc, relSpinInc, tempOld, stretchOld, defgradOld, fieldOld, &
                     stressOld, stateOld, enerInternOld, enerInelasOld, tempNew, stretchNew, defgradNew, fieldNew, &
                     stressNew, stateNew, enerInternNew, enerInelasNew)
      import
      character(80) :: cmname
      integer :: nblock, ndir, nshr, nstatev, nfieldv, nprops, lanneal
      real(c_double) :: stepTime, totalTime, dt, props(nprops), density(nblock)
      real(c_double) :: strainInc(nblock, ndir + nshr), stressOld(nblock, ndir + nshr), stressNew(nblock, ndir + nshr)
      real(c_double) :: stateOld(nblock, nstatev), stateNew(nblock, nstatev)
      real(c_double) :: enerInternOld(nblock), enerInelasOld(nblock), enerInternNew(nblock), enerInelasNew(nblock)
      real(c_double) :: coordMp(*), charLength(*), relSpinInc(*), tempOld(*), stretchOld(*), defgradOld(*), &
                        fieldOld(*), tempNew(*), stretchNew(*), defgradNew(*), fieldNew(*)
    end subroutine
  end interface

  ! What a law does not look at.
  real(c_double) :: unused(1) = 0
  integer :: nowhere(1) = 0

contains

  subroutine call_vuinter(name, props, components, variables, count, rdisp, drdisp, stress, statev, sed, sfd, spd)
    character(*), intent(in) :: name
    integer, intent(in) :: components, variables, count
    real(c_double) :: props(:), rdisp(components, count), drdisp(components, count), stress(components, count), &
                      statev(variables, count), sed(count), sfd(count), spd(count), others(count)
    character(80) :: surface
    surface = name
    call vuinter(sfd, others, spd, others, stress, unused, unused, sed, statev, 1, 1, 4, count, 1, components - 1, &
                 components, variables, size(props), 0, 0, 0, nowhere, nowhere, nowhere, unused(1), unused(1), &
                 1e-6_c_double, surface, surface, surface, rdisp, drdisp, unused, unused, unused, unused, unused, &
                 unused, unused, props, unused, unused, unused, unused, unused, unused, unused, unused, unused)
  end subroutine

  subroutine call_vumat(name, props, variables, count, time, strain, old, state_old, inelastic_old, new, state_new, &
                        internal, inelastic)
    character(*), intent(in) :: name
    integer, intent(in) :: variables, count
    real(c_double) :: props(:), time, strain(count, 3), old(count, 3), state_old(count, variables), &
                      inelastic_old(count), new(count, 3), state_new(count, variables), internal(count), &
                      inelastic(count), density(count)
    character(80) :: material
    material = name
    density = 2
    call vumat(count, 1, 2, variables, 0, size(props), 0, time, time, 1e-6_c_double, material, unused, unused, props, &
               density, strain, unused, unused, unused, unused, unused, old, state_old, inelastic_old, inelastic_old, &
               unused, unused, unused, unused, new, state_new, internal, inelastic)
  end subroutine

end module

program main
  use abaqus_calls
  use direct_law
  implicit none
  ! Table 1 of the paper, mortar joint; a law takes those of its properties that are here.
  character(kind=c_char, len=32), parameter :: mortar_ids(9) = [character(kind=c_char, len=32) :: "normal_stiffness", &
    "shear_stiffness", "tensile_strength", "cohesion", "friction_angle", "compressive_strength", &
    "fracture_energy_tension", "fracture_energy_shear", "fracture_energy_compression"]
  real(c_double), parameter :: mortar(9) = [82.0e9_c_double, 36.0e9_c_double, 0.2e6_c_double, 0.3e6_c_double, &
    35.0_c_double, 5.0e6_c_double, 15.0_c_double, 125.0_c_double, 8000.0_c_double]
  real(c_double), parameter :: default = -9999
  integer, parameter :: steps = 1000
  character(1000) :: name, mode, folder
  character(kind=c_char, len=32), allocatable, target :: ids(:)
  real(c_double), allocatable, target :: numbers(:)
  real(c_double), allocatable :: props(:)
  logical :: energies

  call get_command_argument(1, name)
  call get_command_argument(2, mode)
  call get_environment_variable("QUOIN_LAW_PATH", folder)
  if (index(name, "fault-") == 1) call provoke(trim(name))
  call read_properties()
  if (mode == "time") then
    call print_times(1)
    call print_times(1000)
  else
    call compare_vuinter(3, 136)
    call compare_vuinter(2, 7)
    call compare_vumat(136)
    call check_dry()
  end if

contains

  subroutine require(ok, what)
    logical, intent(in) :: ok
    character(*), intent(in) :: what
    if (ok) return
    print "(2a)", "failed: ", what
    error stop 1
  end subroutine

  subroutine open_reference(points, count)
    type(direct), intent(out) :: points
    integer, intent(in) :: count
    call open_direct(points, trim(folder) // "/" // trim(name) // ".so", ids, numbers, count)
    energies = iand(points%law%capabilities, 1_c_int64_t) /= 0
  end subroutine

  subroutine read_properties()  ! the deck's list, and the same by id for the law called directly
    type(quoin_law), pointer :: law
    type(c_ptr), pointer :: infos(:)
    type(quoin_property_info), pointer :: info
    type(quoin_state_info), pointer :: state
    character(:), allocatable :: reason
    integer :: i, k
    law => open_law(trim(folder) // "/" // trim(name) // ".so", reason)
    call require(associated(law), reason)
    call c_f_pointer(law%properties, infos, [law%property_count])
    allocate (ids(0), numbers(0), props(0))
    do i = 1, size(infos)
      call c_f_pointer(infos(i), info)
      if (info%kind == 3) cycle
      props = [props, default]
      do k = 1, size(mortar)
        if (fortran_text(info%id) /= mortar_ids(k)) cycle
        props(size(props)) = mortar(k)
        ids = [character(kind=c_char, len=32) :: ids, trim(mortar_ids(k)) // c_null_char]
        numbers = [numbers, mortar(k)]
      end do
    end do
    call c_f_pointer(law%states, infos, [law%state_count])
    do i = 1, size(infos)
      call c_f_pointer(infos(i), state)
      if (state%kind /= 1) print "(a)", "to be refused: vector state"
    end do
  end subroutine

  ! d_n, d_s, d_t of point i at the end of a step: cycles of opening, of sliding under pressure, of crushing.
  function displacement(i, step) result(d)
    integer, intent(in) :: i, step
    real(c_double) :: d(3), t, cycle
    t = real(step, c_double) / steps
    cycle = t * (1 + 0.6_c_double * sin(40 * t)) * (1 + 0.01_c_double * i)
    select case (mod(i, 3))
    case (0)
      d = [2.0e-4_c_double * cycle, 1.0e-6_c_double * t, -2.0e-6_c_double * cycle]
    case (1)
      d = [-2.0e-6_c_double, 2.0e-3_c_double * cycle, 5.0e-4_c_double * t * sin(25 * t)]
    case default
      d = [-4.0e-4_c_double * cycle, 1.0e-7_c_double * cycle, 0.0_c_double]
    end select
  end function

  subroutine compare_vuinter(components, count)
    integer, intent(in) :: components, count
    type(direct) :: points
    real(c_double) :: rdisp(components, count), drdisp(components, count), stress(components, count), before(count)
    real(c_double) :: sed(count), sfd(count), spd(count), difference, largest, d(3)
    real(c_double), allocatable :: statev(:, :)
    integer :: i, step, variables
    call open_reference(points, count)
    variables = points%state_count + 3
    allocate (statev(variables, count))
    statev = 0
    statev(variables, :) = 7  ! not the law's
    rdisp = 0
    stress = 0
    difference = 0
    largest = 0
    do step = 1, steps
      do i = 1, count
        d = displacement(i, step)
        d(1) = -d(1)
        drdisp(:, i) = d(1:components) - rdisp(:, i)
        rdisp(:, i) = rdisp(:, i) + drdisp(:, i)
      end do
      before = rdisp(1, :)
      call call_vuinter(trim(name) // "-BONDED", props, components, variables, count, rdisp, drdisp, stress, statev, &
                        sed, sfd, spd)
      call require(all(rdisp(1, :) == before), "rdisp is as it was")
      points%jump = -rdisp(1, :)
      do i = 1, components - 1
        points%slip(:, i) = drdisp(i + 1, :)
      end do
      call step_direct(points, energies)
      difference = max(difference, maxval(abs(stress(1, :) + points%traction(:, 1))))
      do i = 2, components
        difference = max(difference, maxval(abs(stress(i, :) - points%traction(:, i))))
      end do
      largest = max(largest, maxval(abs(stress)))
      do i = 1, points%state_count
        call require(all(statev(i, :) == points%state(:, i)), "states of VUINTER")
      end do
      if (energies) then
        call require(all(sed == points%stored), "stored energy")
        call require(all(sfd == points%dissipated(:, 3)), "friction")
        call require(all(abs(spd - points%dissipated(:, 1) - points%dissipated(:, 2) - points%dissipated(:, 4)) &
                         <= 1e-12_c_double * maxval(abs(spd))), "dissipation without friction")
      end if
    end do
    call require(all(statev(points%state_count + 1, :) == 1), "every point is started")
    call require(all(statev(variables, :) == 7), "further state variables are let alone")
    print "(2a, i0, a, i0, a, i0, a, es8.2, a, es8.2, a)", trim(name), ", VUINTER ", components, "D: ", count, &
      " nodes, ", steps, " steps, stress up to ", largest, " Pa, largest difference ", difference, " Pa"
    call require(difference <= 0 .and. largest > 1e5, "the curve of VUINTER")
  end subroutine

  subroutine compare_vumat(count)
    integer, intent(in) :: count
    type(direct) :: points
    real(c_double) :: strain(count, 3), stress(count, 3, 0:1), internal(count), inelastic(count, 0:1), at(count, 3)
    real(c_double) :: difference, largest, zero(count, 3), dissipated(count)
    real(c_double), allocatable :: state(:, :, :)
    integer :: i, step, old, new, variables
    call open_reference(points, count)
    variables = points%state_count + 2
    allocate (state(count, variables, 0:1))
    state = 0
    stress = 0
    inelastic = 0
    zero = 0
    at = 0
    difference = 0
    largest = 0
    dissipated = 0
    strain = 1e-3_c_double  ! invented, before time begins: elastic, and forgotten
    call call_vumat(trim(name), props, variables, count, 0.0_c_double, strain, zero, state(:, :, 0), inelastic(:, 0), &
                    stress(:, :, 1), state(:, :, 1), internal, inelastic(:, 1))
    call require(all(abs(stress(:, 1, 1) - props(1) * 1e-3_c_double) <= 1e-12_c_double * stress(:, 1, 1)), "stiffness n")
    call require(all(abs(stress(:, 2, 1) - props(2) * 1e-3_c_double) <= 1e-12_c_double * stress(:, 2, 1)), "stiffness s")
    do step = 1, steps
      old = mod(step - 1, 2)
      new = mod(step, 2)
      do i = 1, count
        strain(i, :) = displacement(i, step) - at(i, :)
      end do
      at = at + strain
      call call_vumat(trim(name), props, variables, count, 1e-6_c_double * step, strain, stress(:, :, old), &
                      state(:, :, old), inelastic(:, old), stress(:, :, new), state(:, :, new), internal, &
                      inelastic(:, new))
      points%jump = at(:, 1)
      points%slip = strain(:, 2:3)
      call step_direct(points, energies)
      difference = max(difference, maxval(abs(stress(:, :, new) - points%traction)))
      largest = max(largest, maxval(abs(stress(:, :, new))))
      call require(all(state(:, 1:points%state_count, new) == points%state), "states of VUMAT")
      if (energies) then
        dissipated = dissipated + sum(points%dissipated, dim=2) / 2
        call require(all(abs(inelastic(:, new) - dissipated) <= 1e-12_c_double * (1 + dissipated)), "inelastic energy")
        call require(all(abs(internal - dissipated - points%stored / 2) <= 1e-9_c_double * (1 + internal)), "energy")
      end if
    end do
    print "(2a, i0, a, i0, a, es8.2, a, es8.2, a)", trim(name), ", VUMAT: ", count, " points, ", steps, &
      " steps, stress up to ", largest, " Pa, largest difference ", difference, " Pa"
    call require(difference <= 0 .and. largest > 1e5, "the curve of VUMAT")
  end subroutine

  subroutine check_dry()  ! another initial state by the name, in capitals: a dry joint has no tension
    real(c_double) :: rdisp(3, 1), drdisp(3, 1), stress(3, 1), statev(16, 1), sed(1), sfd(1), spd(1)
    real(c_double) :: strain(1, 3), old(1, 3), new(1, 3), state_old(1, 16), state_new(1, 16)
    character(80) :: capitals
    integer :: i
    if (trim(name) == "elastic" .or. trim(name) == "template_law") return  ! never break
    capitals = trim(name) // "-dry-floor_2"
    do i = 1, len_trim(capitals)
      if (capitals(i:i) >= "a" .and. capitals(i:i) <= "z") capitals(i:i) = achar(iachar(capitals(i:i)) - 32)
    end do
    rdisp = 0
    drdisp = 0
    stress = 0
    statev = 0
    rdisp(1, 1) = -1e-7_c_double
    call call_vuinter(trim(capitals), props, 3, 16, 1, rdisp, drdisp, stress, statev, sed, sfd, spd)
    call require(abs(stress(1, 1)) <= 0, "a dry joint carries no tension")
    rdisp(1, 1) = 1e-7_c_double
    call call_vuinter(trim(capitals), props, 3, 16, 1, rdisp, drdisp, stress, statev, sed, sfd, spd)
    call require(abs(stress(1, 1) - props(1) * 1e-7_c_double) <= 1e-9_c_double * stress(1, 1), "and all pressure")
    old = 0
    state_old = 0
    strain = 0
    strain(1, 1) = 1e-7_c_double
    call call_vumat(trim(capitals), props, 16, 1, 1e-6_c_double, strain, old, state_old, sed, new, state_new, sfd, spd)
    call require(abs(new(1, 1)) <= 0, "a dry cohesive element carries no tension")
    call require(all(state_old == 0), "old state variables are let alone")
  end subroutine

  subroutine provoke(fault)  ! each ends the program with a message
    character(*), intent(in) :: fault
    real(c_double) :: one(3, 1), statev(16, 1), e(1), nan
    integer :: variables
    one = 0
    statev = 0
    e = 0
    nan = 0
    variables = 16
    allocate (props(2))
    props = [4.0e10_c_double, 2.0e10_c_double]
    name = "elastic"
    select case (fault)
    case ("fault-law")
      name = "no_such_law"
    case ("fault-initial-state")
      name = "elastic-wet"
    case ("fault-property")
      props(1) = -5
    case ("fault-too-many-properties")
      props = [props, props]
    case ("fault-state-variables")
      variables = 0
    case ("fault-not-a-number")
      one(1, 1) = nan / nan
    end select
    call call_vuinter(trim(name), props, 3, variables, 1, one, one, one, statev, e, e, e)
    stop  ! not reached
  end subroutine

  subroutine print_times(count)
    integer, intent(in) :: count
    type(direct) :: points
    real(c_double) :: rdisp(3, count), drdisp(3, count), stress(3, count), sed(count), sfd(count), spd(count)
    real(c_double), allocatable :: statev(:, :)
    call open_reference(points, count)
    allocate (statev(points%state_count + 1, count))
    statev = 0
    rdisp = 0
    rdisp(1, :) = 1e-7_c_double
    drdisp = 0
    stress = 0
    points%jump = -1e-7_c_double
    block
      integer(c_int64_t) :: from, to, rate, repeats, run, i
      real(c_double) :: best(2)
      repeats = max(1, 400 / count)
      best = huge(best)
      do run = 1, 3000
        call system_clock(from, rate)
        do i = 1, repeats
          call call_vuinter(trim(name), props, 3, size(statev, 1), count, rdisp, drdisp, stress, statev, sed, sfd, spd)
        end do
        call system_clock(to)
        best(1) = min(best(1), real(to - from, c_double))
        call system_clock(from)
        do i = 1, repeats
          call step_direct(points, energies)
        end do
        call system_clock(to)
        best(2) = min(best(2), real(to - from, c_double))
      end do
      best = best * 1e9_c_double / (real(rate, c_double) * repeats * count)
      print "(2a, i0, 2(a, f0.1), a)", trim(name), ", ", count, " points: ", best(1), " ns a point through VUINTER, ", &
        best(2), " ns direct, energies included"
    end block
  end subroutine

end program
