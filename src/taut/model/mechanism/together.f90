!> Which bodies of a mechanism move together, and what turns about a point of the ground.
submodule(taut_model_mechanism) taut_model_mechanism_together
   use taut_model_mechanism_body, only: body_planar, body_spatial
   use taut_model_mechanism_joint, only: keeps_points_together
   use taut_model_mechanism_joint_table, only: type_fixed
   implicit none (type, external)

contains

   !> Which bodies move together, and what turns about a point of the ground: by the first joint, if there are several.
   module procedure find_parts
      integer :: b, body, i

      call follow_welds(self, root, weld, followers)
      pin(:) = 0
      if (.not. self%planar) return
      do i = 1, size(self%joints)
         associate (it => self%joints(i))
            body = max(root_of(it%body_1), root_of(it%body_2))
            if (min(root_of(it%body_1), root_of(it%body_2)) /= 0 .or. body == 0) cycle
            if (pin(body) > 0 .or. self%bodies(body)%kind /= body_planar .or. .not. keeps_points_together(it)) cycle
            b = merge(it%body_1, it%body_2, root_of(it%body_1) == body)
            if (self%bodies(b)%kind /= body_planar) cycle
            pin(body) = i
         end associate
      end do

   contains

      !> The body with which one moves.
      integer function root_of(b)
         integer, intent(in) :: b

         root_of = 0
         if (b > 0) root_of = root(b)
      end function root_of

   end procedure find_parts

   !> Goes along welds, from the ground first and then from each body that was not reached. Where a drive acts within a part, it
   !! is seen that it cannot move: all stay as they are.
   subroutine follow_welds(self, root, weld, followers)
      class(mechanism_t), intent(in) :: self
      integer, intent(out) :: root(:), weld(:)
      integer, allocatable, intent(out) :: followers(:)
      integer :: ends(2), first(0:size(root) + 1), i, k, n, queue(size(root)), side, start
      integer, allocatable :: list(:)
      logical :: able(0:size(root)), welds(size(self%joints))

      root = [(i, i=1, size(root))]
      weld(:) = 0
      allocate (followers(0))
      ! A point mass does not turn, and what is welded to it cannot; nodes of beams have coordinates of their own.
      able(0) = .true.
      able(1:) = self%bodies%kind == body_planar .or. self%bodies%kind == body_spatial
      do i = 1, size(self%elements)
         able([self%elements(i)%body_1, self%elements(i)%body_2]) = .false.
      end do
      do i = 1, size(welds)
         associate (it => self%joints(i))
            welds(i) = it%type == type_fixed .and. able(it%body_1) .and. able(it%body_2)
         end associate
      end do
      if (.not. any(welds)) return

      ! The welds of each body, in compressed rows.
      first = 0
      do i = 1, size(welds)
         if (.not. welds(i)) cycle
         ends = [self%joints(i)%body_1, self%joints(i)%body_2]
         first(ends) = first(ends) + 1
      end do
      first(0) = first(0) + 1
      do i = 1, size(first) - 1
         first(i) = first(i - 1) + first(i)
      end do
      allocate (list(first(size(root)) - 1))
      do i = size(welds), 1, -1
         if (.not. welds(i)) cycle
         ends = [self%joints(i)%body_1, self%joints(i)%body_2]
         first(ends) = first(ends) - 1
         list(first(ends)) = i
      end do

      n = 0
      call reach(0, 0)
      do start = 1, size(root)
         if (weld(start) == 0) call reach(start, start)
      end do
      do i = 1, size(self%joints)
         associate (it => self%joints(i))
            if (max(it%drive, it%angle_drive) == 0) cycle
            if (root_or_ground(it%body_1) /= root_or_ground(it%body_2)) cycle
            root = [(k, k=1, size(root))]
            weld(:) = 0
            return
         end associate
      end do
      followers = queue(:n)

   contains

      !> All that is welded to a body that was reached, and what is welded to that.
      subroutine reach(from, its_root)
         integer, intent(in) :: from, its_root
         integer :: at, done

         at = from
         done = n
         do
            do k = first(at), first(at + 1) - 1
               associate (it => self%joints(list(k)))
                  side = it%body_1 + it%body_2 - at
               end associate
               if (side == 0 .or. side == its_root) cycle
               if (weld(side) > 0) cycle
               weld(side) = list(k)
               root(side) = its_root
               n = n + 1
               queue(n) = side
            end do
            done = done + 1
            if (done > n) return
            at = queue(done)
         end do
      end subroutine reach

      !> The body with which one moves; 0 for the ground.
      integer function root_or_ground(b)
         integer, intent(in) :: b

         root_or_ground = 0
         if (b > 0) root_or_ground = root(b)
      end function root_or_ground

   end subroutine follow_welds

end submodule taut_model_mechanism_together
